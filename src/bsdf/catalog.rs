//! Every model by name: what `list` prints, what a SUBJECT is made from, and what the laws are tested on.

use super::measured::{abc, sgd};
use super::subject::{Args, ParamSpec, SubjectError};
use super::{
    Bsdf, ashikhmin_shirley, blinn_phong, burley, dielectric, disney, eon, fon, lambert, lommel_seeliger, microfacet,
    minnaert, mix, null, oren_nayar, phong, plastic, specular, thin_dielectric, two_sided, ward,
};

/// One model of the catalog. Each model's file defines its own.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name in `name:key=value,…`.
    pub name: &'static str,
    /// One line: what it is, with its formula where that fits.
    pub summary: &'static str,
    /// The parameters, in the order in which they are shown.
    pub params: &'static [ParamSpec],
    /// Subjects that show the model's range; each is put through the whole verdict sheet. None for a model with a
    /// parameter `file`.
    pub examples: &'static [Example],
    /// Makes the model.
    pub build: fn(&Args) -> Result<Box<dyn Bsdf>, SubjectError>,
}

/// A subject, and the laws that it is known to break.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// `name:key=value,…`.
    pub subject: &'static str,
    /// The checks of the verdict sheet that must fail, with good reason, stated in the model's file; all others must not.
    pub breaks: &'static [&'static str],
}

impl Example {
    /// A subject that obeys every law.
    pub const fn lawful(subject: &'static str) -> Self {
        Self { subject, breaks: &[] }
    }

    /// A subject that fails exactly these checks.
    pub const fn breaking(subject: &'static str, breaks: &'static [&'static str]) -> Self {
        Self { subject, breaks }
    }
}

/// All models, in the order in which they are shown.
#[rustfmt::skip] // One a line.
pub static MODELS: &[Entry] = &[
    lambert::ENTRY,
    phong::ENTRY,
    blinn_phong::ENTRY,
    microfacet::GGX,
    microfacet::BECKMANN,
    microfacet::BLINN,
    oren_nayar::ENTRY,
    fon::ENTRY,
    eon::ENTRY,
    burley::ENTRY,
    disney::ENTRY,
    ashikhmin_shirley::ENTRY,
    ward::ENTRY,
    minnaert::ENTRY,
    lommel_seeliger::ENTRY,
    sgd::ENTRY,
    abc::ENTRY,
    specular::MIRROR,
    specular::CONDUCTOR,
    dielectric::ENTRY,
    thin_dielectric::ENTRY,
    microfacet::ROUGH_DIELECTRIC,
    plastic::ENTRY,
    microfacet::ROUGH_PLASTIC,
    null::ENTRY,
    two_sided::ENTRY,
    mix::ENTRY,
];

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
            // A model that needs a file cannot show itself without one; its tests read the published tables.
            let needs_file = entry.params.iter().any(|param| param.name == "file");
            assert!(needs_file || !entry.examples.is_empty(), "{} has no example", entry.name);
            for example in entry.examples {
                let model = subject::parse(example.subject);
                assert!(model.is_ok(), "{}: {}", example.subject, model.unwrap_err());
            }
        }
    }
}
