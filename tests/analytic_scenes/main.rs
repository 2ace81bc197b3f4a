//! The path tracer against closed forms: direct light, light reflected r times and without end, the spread of its
//! samples, and its symmetries. Levels are family-wise: see `Family`.

#[path = "../common/mod.rs"]
mod common;

mod bounces;
mod direct;
mod spread;
mod symmetry;
