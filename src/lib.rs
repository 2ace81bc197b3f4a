//! The numerics of BRDFs and of the rendering equation: models with their samplers, integrals that state their error, one
//! sheet of verdicts for any BRDF, and path-traced images with the error of every pixel.
//!
//! ```text
//! math -> image -> sampling -> bsdf -> integrate -> validate -> scene -> render -> converge -> report -> cli
//!         pixels   uniforms    f       albedo       verdicts    shapes   paths     rates       tables    SUBJECT, SCENE
//!         files    -> wi       pdf     ± error      power       lights   film      against     plots     -> exit status
//!                              sample               twins       rays     furnace   theory      HTML
//! ```
//! No module knows a later one, and a test sees to it.
//!
//! # Conventions
//! 1. Local frame: the normal is +z. `wo` and `wi` are unit vectors away from the surface; `wo` is known, `wi` is
//!    sampled.
//! 2. `eval` is f [1/sr] without the cosine; the cosine is |wi.z|.
//! 3. `pdf` is per steradian at `wi`, given `wo`. Its integral is 1 less the probability of a lost draw.
//! 4. `sample` is a pure function of `wo` and three uniforms. Its weight is f |cos| / density.
//! 5. None is a lost draw: it counts as 0, and every estimator divides by all draws.
//! 6. Opaque models are one-sided: black, 0 and None unless `wo.z` > 0 and `wi.z` > 0.
//! 7. `alpha` is the slope width of a distribution of microfacet normals. Nothing squares it.
//! 8. Angles are radians; degrees only where a name ends in `_deg`, and on the command line. Colours are linear Rec.709.
//! 9. `eval`, `pdf` and `sample` are total: no panic and no NaN, whatever the arguments. Constructors refuse bad
//!    parameters.
//! 10. The same seed gives the same bits, on any number of threads.
//!
//! # A first sheet
//! ```
//! use whitefurnace::prelude::*;
//!
//! let mine = FnBsdf::new("mine", |wo: DVec3, wi: DVec3| {
//!     Rgb::grey(if wo.z > 0.0 && wi.z > 0.0 { 0.2 + 0.1 * wo.z * wi.z } else { 0.0 })
//! });
//! let sheet = Suite { effort: Effort::Quick, ..Suite::default() }.run(&mine);
//! assert_eq!(sheet.outcome(), Outcome::Pass, "{sheet:#?}");
//! ```
//! [`design`] tells why things are as they are; the numbered files in `examples/` are a guided tour.

pub mod bsdf;
pub mod cli;
pub mod converge;
pub mod image;
pub mod integrate;
pub mod math;
pub mod render;
pub mod report;
pub mod sampling;
pub mod scene;
pub mod validate;

pub use glam;

/// What a program that brings or uses BRDFs needs, in one import.
pub mod prelude {
    pub use crate::bsdf::measured::{Abc, Sgd, SgdParams};
    pub use crate::bsdf::{
        AshikhminShirley, Beckmann, Blinn, BlinnPhong, BlinnPhongNorm, Bsdf, BsdfSample, Burley, Compensation, Density,
        Dielectric, Disney, DisneyParams, Eon, FnBsdf, Fon, Fresnel, Ggx, InternalReflectance, Lambert, Lobes,
        LommelSeeliger, Masking, Minnaert, Mix, Null, OrenNayar, ParamError, Phong, PhongNorm, Plastic,
        RoughDielectric, RoughPlastic, Sampling, SpecularReflector, ThinDielectric, TwoSided, Uniforms, Ward,
        WardVariant,
    };
    pub use crate::integrate::{Estimate, Hemisphere, Integral, Side};
    pub use crate::math::color::Rgb;
    pub use crate::render::Radiance;
    pub use crate::render::film::Film;
    pub use crate::render::path::{PathTracer, Roulette, Strategy};
    pub use crate::render::progressive::{Job, Stop};
    pub use crate::sampling::filter::Filter;
    pub use crate::sampling::sampler::{Sampler, SamplerKind};
    pub use crate::scene::{
        Camera, FilmSettings, Geometry, Light, Material, Mesh, Ray, RenderSettings, Scene, SceneDescription, Shape,
    };
    pub use crate::validate::{Check, Effort, Outcome, Sheet, Suite, suite};
    pub use glam::{DVec2, DVec3};
}

/// Why things are as they are.
pub mod design {
    #![doc = include_str!("../DESIGN.md")]
}

/// The code blocks of the README, compiled and run as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
