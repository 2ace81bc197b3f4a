//! Files for tests.

use std::path::PathBuf;

use tempfile::TempDir;

use super::{LoadOptions, Loaded, SceneError, load};

/// Files in a folder of their own, which lasts as long as this.
pub(super) struct Files(TempDir);

impl Files {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// The same with this file.
    pub(super) fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        self
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(super) fn load(&self, name: &str) -> Result<Loaded, SceneError> {
        load(&self.path(name), &LoadOptions::default())
    }

    pub(super) fn lenient(&self, name: &str) -> Result<Loaded, SceneError> {
        load(&self.path(name), &LoadOptions { lenient: true, ..LoadOptions::default() })
    }

    /// The error for `name`, without the name of the folder. It is one line, and one that names the file.
    pub(super) fn error(&self, name: &str) -> String {
        let error = self.load(name).expect_err("this file is bad").to_string();
        let folder = format!("{}/", self.0.path().display());
        assert!(error.starts_with(&folder) && !error.contains('\n'), "{error}");
        error.replace(&folder, "")
    }
}

/// Every prefix of `content`, and `content` with bytes changed, loaded as `name`: nothing panics, and nothing is slow.
pub(super) fn mutate(name: &str, content: &[u8], others: &[(&str, &[u8])], changes: usize) {
    use rand::{RngExt, SeedableRng};
    let mut files = Files::new();
    for (other, content) in others {
        files = files.with(other, content);
    }
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(7);
    let start = std::time::Instant::now();
    let mut loads = 0;
    let mut attempt = |bytes: &[u8]| {
        std::fs::write(files.path(name), bytes).unwrap();
        for result in [files.load(name), files.lenient(name)] {
            if let Err(error) = result {
                let error = error.to_string();
                assert!(error.contains(name) && !error.contains('\n') && error.len() < 3000, "{error}");
            }
            loads += 1;
        }
    };
    let step = (content.len() / 200).max(1);
    for end in (0..content.len()).step_by(step) {
        attempt(&content[..end]);
    }
    for _ in 0..changes {
        let mut bytes = content.to_vec();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(0..bytes.len());
            match rng.random_range(0..5) {
                0 => bytes[at] = rng.random_range(0..=255),
                1 => bytes[at] = [b'9', b'-', b'0', b'"', b'<', 255, 0][rng.random_range(0..7)],
                2 => drop(bytes.remove(at)),
                3 => bytes.insert(at, b"9-e<\"/ \n"[rng.random_range(0..8)]),
                _ => {
                    let end = rng.random_range(at..bytes.len().min(at + 20));
                    let piece = bytes[at..end].to_vec();
                    let to = rng.random_range(0..bytes.len());
                    bytes.splice(to..to, piece);
                }
            }
            if bytes.is_empty() {
                break;
            }
        }
        attempt(&bytes);
    }
    // A second each would be slow; a thousandth is usual. Loaded machines are ten times slower.
    let mean = start.elapsed().as_secs_f64() / f64::from(loads);
    assert!(mean < 0.05, "{mean} s per load");
}
