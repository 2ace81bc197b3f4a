//! Output files that are replaced only when the new one is complete.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file to be written whole or not at all.
#[derive(Clone, Debug)]
pub struct Target {
    path: PathBuf,
    /// A device or pipe, such as `/dev/stdout`: it cannot be replaced, only written to.
    special: bool,
}

impl Target {
    /// Looks whether `path` can be written, without touching what is there.
    pub fn new(path: PathBuf) -> io::Result<Self> {
        // A link is followed, so that it stays and what it points at is replaced.
        let path = fs::canonicalize(&path).unwrap_or(path);
        let special = match fs::metadata(&path) {
            Ok(kind) if kind.is_dir() => return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory")),
            Ok(kind) => !kind.is_file(),
            Err(_) => false,
        };
        let target = Self { path, special };
        if !special {
            target.temporary()?;
        }
        Ok(target)
    }

    /// Writes `content` beside the target, then moves it into place: a reader sees the old file or the new one.
    pub fn write(&self, content: &[u8]) -> io::Result<()> {
        if self.special {
            return OpenOptions::new().write(true).open(&self.path)?.write_all(content);
        }
        let mut file = self.temporary()?;
        file.write_all(content)?;
        file.as_file().sync_all()?;
        if let Ok(old) = fs::metadata(&self.path) {
            file.as_file().set_permissions(old.permissions())?;
        }
        file.persist(&self.path).map(|_: File| ()).map_err(|error| error.error)
    }

    /// An empty file in the target's folder, removed unless it is moved into place.
    fn temporary(&self) -> io::Result<tempfile::NamedTempFile> {
        let folder = match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            let reason = format!("there is no folder {}", folder.display());
            return Err(io::Error::new(io::ErrorKind::NotFound, reason));
        }
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As for any new file: readable by all that the umask allows, not private as temporary files are.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        builder.prefix(".whitefurnace-").tempfile_in(folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sheet.json");
        fs::write(&path, "old").unwrap();
        let target = Target::new(path.clone()).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old", "looking must not touch");
        target.write(b"new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_or_a_missing_folder_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Target::new(folder.path().into()).is_err());
        let error = Target::new(folder.path().join("no/such.json")).unwrap_err();
        assert!(error.to_string().contains("there is no folder"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&real, &link).unwrap();
        Target::new(link.clone()).unwrap().write(b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
