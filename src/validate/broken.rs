//! Negative controls.

use crate::bsdf::Bsdf;

/// A wrong twin of a correct model.
#[derive(Debug)]
pub struct Twin {
    /// Name.
    pub name: &'static str,
    /// Why it is wrong.
    pub why: &'static str,
    /// Checks that must fail.
    pub caught_by: &'static [&'static str],
    /// The correct model.
    pub original: fn() -> Box<dyn Bsdf>,
    /// The wrong one.
    pub broken: fn() -> Box<dyn Bsdf>,
}

/// All of them.
pub fn twins() -> &'static [Twin] {
    &[]
}
