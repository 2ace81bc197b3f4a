//! What an interrupted study of an image leaves in its folder: `convergence.state`, and the reference as a checkpoint of a
//! rendering. A study that is done leaves its own reference as a picture instead.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};

use crate::cli::job;
use crate::converge::image::{Extent, State};
use crate::image::Format;
use crate::render::checkpoint::Checkpoint;
use crate::render::film::Film;
use crate::render::provenance::{Provenance, Run};
use crate::report::save::Target;

/// The files in a study's folder.
#[derive(Debug)]
pub(super) struct Kept {
    settings: String,
    state: (PathBuf, Target),
    reference: (PathBuf, Target),
    picture: Target,
}

/// What is to be done about a file of another study.
const ANEW: &str = "--restart begins anew";

impl Kept {
    /// In `folder`, for a study with these settings.
    pub(super) fn new(folder: &Path, settings: &str) -> anyhow::Result<Self> {
        let file = |name: &str| {
            let path = folder.join(name);
            Ok::<_, anyhow::Error>((path.clone(), job::target("--out", path)?))
        };
        Ok(Self {
            settings: settings.into(),
            state: file("convergence.state")?,
            reference: file("reference.wfc")?,
            picture: file("reference.exr")?.1,
        })
    }

    /// Removes what is there.
    pub(super) fn forget(&self) -> anyhow::Result<()> {
        for path in [&self.state.0, &self.reference.0] {
            remove(path).with_context(|| format!("{}: cannot be removed", path.display()))?;
        }
        Ok(())
    }

    /// What has been done, if anything.
    pub(super) fn state(&self, extent: Extent) -> anyhow::Result<State> {
        if !self.state.0.exists() {
            return Ok(State::default());
        }
        State::read(&self.state.0, &self.settings, extent).map_err(|error| anyhow!("{error}; {ANEW}"))
    }

    pub(super) fn keep(&self, state: &State) -> anyhow::Result<()> {
        self.state.1.write(&state.encode(&self.settings)).context("--out: cannot be written")
    }

    /// The film of the reference as far as it is, if there is one.
    pub(super) fn reference(&self, scene: &str, seed: u64) -> anyhow::Result<Option<Film>> {
        let path = &self.reference.0;
        if !path.exists() {
            return Ok(None);
        }
        let found = Checkpoint::read(path).map_err(|error| anyhow!("{error}; {ANEW}"))?;
        let resumable = found.resumable(scene, &self.settings, seed);
        resumable.map_err(|why| anyhow!("{}: {why}; {ANEW}", path.display()))?;
        Ok(Some(found.film))
    }

    pub(super) fn keep_reference(&self, film: &Film, scene: &str, seed: u64) -> anyhow::Result<()> {
        let state = Checkpoint { film: film.clone(), provenance: self.provenance(film, scene, seed) };
        self.reference.1.write(&state.encode()).context("--out: cannot be written")
    }

    fn provenance(&self, film: &Film, scene: &str, seed: u64) -> Provenance {
        // Where the work was cut short, some pixels have fewer: the numbers in between count as taken.
        let run = Run { seed, first: 0, count: film.most_drawn() };
        Provenance::new(scene, &self.settings, run, 0.0)
    }

    /// The study is done: its state goes, its own reference stays as a picture that states its error.
    pub(super) fn finish(&self, own: Option<&Film>, scene: &str, seed: u64) -> anyhow::Result<()> {
        if let Some(film) = own {
            let picture = film.to_image(&self.provenance(film, scene, seed).metadata());
            self.picture.write(&picture.encode(Format::Exr, 0.0)?).context("--out: cannot be written")?;
        }
        self.forget()
    }
}

/// Removes a file that may not be there.
fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
