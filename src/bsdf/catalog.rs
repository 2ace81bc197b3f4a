//! Every model by name: what `list` prints, what a SUBJECT is made from, and what the laws are tested on.

use super::subject::{Args, ParamSpec, SubjectError};
use super::{Bsdf, lambert};

/// One model of the catalog. Each model's file defines its own.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name in `name:key=value,…`.
    pub name: &'static str,
    /// One line: what it is, with its formula where that fits.
    pub summary: &'static str,
    /// The parameters, in the order in which they are shown.
    pub params: &'static [ParamSpec],
    /// Subjects that show the model's range; each is put through the whole verdict sheet.
    pub examples: &'static [&'static str],
    /// Makes the model.
    pub build: fn(&Args) -> Result<Box<dyn Bsdf>, SubjectError>,
}

/// All models, in the order in which they are shown.
pub static MODELS: &[Entry] = &[lambert::ENTRY];

/// The model called `name`.
pub fn find(name: &str) -> Option<&'static Entry> {
    MODELS.iter().find(|entry| entry.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::subject;

    #[test]
    fn every_example_can_be_made_and_every_default_is_allowed() {
        for entry in MODELS {
            assert!(!entry.examples.is_empty(), "{} has no example", entry.name);
            for example in entry.examples {
                let model = subject::parse(example);
                assert!(model.is_ok(), "{example}: {}", model.unwrap_err());
            }
        }
    }
}
