//! The verdict sheet: checks of a BRDF that say what they found, and how large an error they would have caught.

mod check;

pub use check::{Check, Outcome, Sheet};
