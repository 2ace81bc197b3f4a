//! Negative controls: models with one known mistake each, and the checks that must reject them.
//!
//! A check that cannot fail proves nothing. Each [`Twin`] pairs a correct model with a copy that has one mistake, taken
//! from the bug trackers of real systems where there is one, and names the checks that must find it.
//!
//! - `values`: f itself is wrong
//! - `densities`: the sampler is right, but claims another density or weight
//! - `draws`: the density is right, but the sampler draws something else
//! - `interfaces`: transmission, Dirac lobes, the side below
//! - [`Chimera`]: f, density and draws of three different models
//! - [`Unmatched`]: microfacets whose distribution and masking do not belong together

mod chimera;
mod densities;
mod draws;
mod flaw;
mod interface_twins;
mod interfaces;
mod normals;
mod twins;
mod values;

pub use chimera::Chimera;
pub use densities::{
    ClampedCosine, DensityOff, FlippedPdf, FresnelInPdf, MissingCosine, RareHugeWeight, ScaledPdf, StaleWeight,
    UniformPdf, VCavityPdf, WeightOff, WrongJacobian,
};
pub use draws::{
    BelowTheHorizon, BiasedLobe, Correlated, Dropped, HalfTurn, Hole, Leak, MirroredHalfVector, MissingSquareRoot,
    NanAtZero, OnlyOnAverage, Redrawn, ReusedUniform, Rotated, UnflippedHalfVector,
};
pub use interfaces::{
    CarriesRadiance, DiracProbabilityOff, FreeExit, GainFromBelow, InverseSnell, OneWay, ReflectionJacobian,
    SameIndexInside, SignedCosine, SqueezedBeam, UnsharedPdf,
};
pub use normals::{Unmatched, ggx_masking, no_masking, rational_beckmann, remapped_schlick, rougher_ggx};
pub use twins::{Twin, twins};
pub use values::{
    Asymmetric, CosineInEval, DividedByCosine, ExtraPi, FalseClaim, Gain, GainAtGrazing, MissingPi, NanAtCosineOne,
    NanAtTheNormal, Negative, WrongAlbedo,
};
