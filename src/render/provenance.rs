//! Where the samples of a film come from: scene, settings, seeds and ranges of sample numbers.
//!
//! Sample number s of a pixel under a seed is the same wherever it is computed, so two films may be merged only if no
//! (seed, s) is in both: the mean would count it twice, and the variance would be too small.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// The samples `first` to `first + count − 1` of every pixel under one seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Run {
    /// The seed.
    pub seed: u64,
    /// Number of the first sample.
    pub first: u64,
    /// How many.
    pub count: u64,
}

impl Run {
    /// The number after the last sample.
    pub fn end(&self) -> u64 {
        self.first.saturating_add(self.count)
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.seed == other.seed && self.first < other.end() && other.first < self.end()
    }

    fn parse(text: &str) -> Option<Self> {
        let (seed, range) = text.trim().strip_prefix("seed ")?.split_once(": ")?;
        let (first, end) = range.split_once("..")?;
        let (first, end): (u64, u64) = (first.parse().ok()?, end.parse().ok()?);
        Some(Self { seed: seed.parse().ok()?, first, count: end.checked_sub(first)? })
    }
}

/// `seed 1: 0..64`.
impl fmt::Display for Run {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "seed {}: {}..{}", self.seed, self.first, self.end())
    }
}

/// What a film holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The scene, in words that differ for different scenes.
    pub scene: String,
    /// Everything else that decides the expectation or the numbers of the samples: size, strategy, filter, sampler, ….
    pub settings: String,
    /// Which samples, sorted and disjoint.
    pub runs: Vec<Run>,
    /// Seconds of rendering.
    pub seconds: f64,
}

/// Why two films must not be merged, or words are no provenance.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ProvenanceError {
    /// Films of different scenes.
    #[error("the scenes differ: {0} and {1}")]
    Scene(String, String),
    /// Films of different settings.
    #[error("the settings differ: {0} and {1}")]
    Settings(String, String),
    /// The same samples twice.
    #[error("both hold the same samples: {0} and {1}")]
    Overlap(Run, Run),
    /// A picture that does not say what it holds.
    #[error("the picture does not say its {0}, so its samples might be merged twice")]
    Missing(&'static str),
    /// Words that are no runs.
    #[error("runs are {0:?}; expected is `seed SEED: FIRST..END; …`")]
    Runs(String),
}

impl Provenance {
    /// The samples of one run.
    pub fn new(scene: &str, settings: &str, run: Run, seconds: f64) -> Self {
        Self { scene: scene.into(), settings: settings.into(), runs: vec![run], seconds }
    }

    /// Samples per pixel.
    pub fn samples(&self) -> u64 {
        self.runs.iter().fold(0, |sum, run| sum.saturating_add(run.count))
    }

    /// Both together.
    pub fn merge(&mut self, other: &Self) -> Result<(), ProvenanceError> {
        if self.scene != other.scene {
            return Err(ProvenanceError::Scene(self.scene.clone(), other.scene.clone()));
        }
        if self.settings != other.settings {
            return Err(ProvenanceError::Settings(self.settings.clone(), other.settings.clone()));
        }
        for mine in &self.runs {
            if let Some(theirs) = other.runs.iter().find(|theirs| mine.overlaps(theirs)) {
                return Err(ProvenanceError::Overlap(*mine, *theirs));
            }
        }
        self.runs.extend(&other.runs);
        self.runs.sort_unstable();
        // Neighbours become one, so that a run in pieces is the run again.
        self.runs.dedup_by(|next, run| {
            let joins = run.seed == next.seed && run.end() == next.first;
            if joins {
                run.count = run.count.saturating_add(next.count);
            }
            joins
        });
        self.seconds += other.seconds;
        Ok(())
    }

    /// The words that stand in a picture.
    pub fn metadata(&self) -> BTreeMap<String, String> {
        let runs: Vec<String> = self.runs.iter().map(ToString::to_string).collect();
        let mut words: BTreeMap<String, String> = [
            ("scene", self.scene.clone()),
            ("settings", self.settings.clone()),
            ("runs", runs.join("; ")),
            ("samples", self.samples().to_string()),
            ("seconds", self.seconds.to_string()),
            ("software", concat!("whitefurnace ", env!("CARGO_PKG_VERSION")).into()),
        ]
        .map(|(key, value)| (key.to_string(), value))
        .into();
        if let [run] = self.runs[..] {
            words.insert("seed".into(), run.seed.to_string());
        }
        words
    }

    /// From the words of a picture.
    pub fn from_metadata(words: &BTreeMap<String, String>) -> Result<Self, ProvenanceError> {
        let word = |key: &'static str| words.get(key).ok_or(ProvenanceError::Missing(key));
        let typed = word("runs")?;
        let wrong = || ProvenanceError::Runs(typed.chars().take(200).collect());
        let mut runs = typed.split(';').map(Run::parse).collect::<Option<Vec<Run>>>().ok_or_else(wrong)?;
        runs.sort_unstable();
        if runs.windows(2).any(|pair| pair[0].overlaps(&pair[1])) {
            return Err(wrong());
        }
        let seconds = words.get("seconds").and_then(|text| text.parse().ok()).unwrap_or(0.0);
        Ok(Self { scene: word("scene")?.clone(), settings: word("settings")?.clone(), runs, seconds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seed: u64, first: u64, count: u64) -> Provenance {
        Provenance::new("box", "mis", Run { seed, first, count }, 1.5)
    }

    #[test]
    fn pieces_of_a_run_become_the_run() {
        let mut all = run(1, 64, 64);
        all.merge(&run(2, 0, 10)).unwrap();
        all.merge(&run(1, 0, 64)).unwrap();
        let expected = [Run { seed: 1, first: 0, count: 128 }, Run { seed: 2, first: 0, count: 10 }];
        assert_eq!((all.runs.as_slice(), all.samples(), all.seconds), (&expected[..], 138, 4.5));
        assert_eq!(all.metadata()["runs"], "seed 1: 0..128; seed 2: 0..10");
        assert_eq!(Provenance::from_metadata(&all.metadata()), Ok(all));
    }

    #[test]
    fn what_must_not_be_merged_names_both() {
        let error = |other: &Provenance| run(1, 0, 64).merge(other).unwrap_err().to_string();
        assert_eq!(error(&run(1, 63, 2)), "both hold the same samples: seed 1: 0..64 and seed 1: 63..65");
        assert_eq!(error(&Provenance { scene: "ball".into(), ..run(2, 0, 1) }), "the scenes differ: box and ball");
        let other = Provenance { settings: "bsdf".into(), ..run(2, 0, 1) };
        assert_eq!(error(&other), "the settings differ: mis and bsdf");
    }

    #[test]
    fn words_that_lie_are_refused() {
        let mut words = run(1, 0, 64).metadata();
        for runs in ["", "seed 1", "seed 1: 5..4", "seed x: 0..1", "seed 1: 0..9; seed 1: 8..10"] {
            words.insert("runs".into(), runs.into());
            assert!(matches!(Provenance::from_metadata(&words), Err(ProvenanceError::Runs(_))), "{runs}");
        }
        words.remove("runs");
        assert_eq!(Provenance::from_metadata(&words), Err(ProvenanceError::Missing("runs")));
    }
}
