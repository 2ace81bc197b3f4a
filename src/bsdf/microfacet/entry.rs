//! The parameters that the microfacet models share in a subject.

use glam::DVec2;

use super::{ALPHA, Compensation, Masking, Microfacet, Normals, Sampling};
use crate::bsdf::fresnel::{self, Fresnel};
use crate::bsdf::subject::{Args, ParamSpec, SubjectError};
use crate::bsdf::{Bsdf, Domain, ParamError};
use crate::math::color::Rgb;

pub(super) const ALPHA_BOTH: ParamSpec = ParamSpec::new("alpha", ALPHA, "slope width; or alpha_x, alpha_y").optional();
pub(super) const ALPHA_X: ParamSpec = ParamSpec::new("alpha_x", ALPHA, "slope width along x").optional();
pub(super) const ALPHA_Y: ParamSpec = ParamSpec::new("alpha_y", ALPHA, "slope width along y").optional();
pub(super) const G: ParamSpec =
    ParamSpec::new("g", Domain::Word(&["correlated", "separable"]), "Smith masking").or("correlated");
pub(super) const F0: ParamSpec =
    ParamSpec::new("f0", fresnel::F0, "Schlick reflectance at normal incidence; 1 unless f0 or eta is given")
        .optional();
pub(super) const ETA: ParamSpec =
    ParamSpec::new("eta", fresnel::ETA, "index of refraction: a dielectric, or with k a conductor").optional();
pub(super) const K: ParamSpec = ParamSpec::new("k", fresnel::K, "extinction coefficient, with eta").optional();
pub(super) const COMPENSATION: ParamSpec = ParamSpec::new(
    "compensation",
    Domain::Word(&["none", "kulla-conty", "turquin"]),
    "of the energy that one bounce loses",
)
.or("none");

/// The parameter `sampling` of a model that knows these methods; the first is the default.
pub(super) const fn sampling(words: &'static [&'static str]) -> ParamSpec {
    ParamSpec::new("sampling", Domain::Word(words), "how normals are drawn").or(words[0])
}

/// The error for `name` given where only `allowed` is possible.
fn conflict(args: &Args, name: &'static str, allowed: &str) -> SubjectError {
    let value = args.text(name).unwrap_or_default().to_owned();
    ParamError::new(args.model(), name, value, allowed).into()
}

/// The slope widths: `alpha`, or both of `alpha_x` and `alpha_y`.
pub(super) fn alphas(args: &Args) -> Result<DVec2, SubjectError> {
    if args.is_given("alpha") {
        for name in ["alpha_x", "alpha_y"] {
            if args.is_given(name) {
                return Err(conflict(args, name, "either alpha or both of alpha_x and alpha_y"));
            }
        }
        return args.number("alpha").map(DVec2::splat);
    }
    if args.is_given("alpha_x") || args.is_given("alpha_y") {
        return Ok(DVec2::new(args.number("alpha_x")?, args.number("alpha_y")?));
    }
    args.number("alpha").map(DVec2::splat)
}

/// What the facets reflect: `f0`, or `eta`, or `eta` and `k`.
fn reflectance(args: &Args) -> Result<Fresnel, SubjectError> {
    if args.is_given("f0") && args.is_given("eta") {
        return Err(conflict(args, "f0", "either f0 or eta"));
    }
    match (args.optional_colour("f0")?, args.optional_colour("eta")?, args.optional_colour("k")?) {
        (_, None, Some(_)) => Err(conflict(args, "k", "k together with eta")),
        (_, Some(eta), Some(k)) => Ok(Fresnel::Conductor { eta, k }),
        (_, Some(eta), None) if eta == Rgb::grey(eta.0.x) => Ok(Fresnel::Dielectric { eta: eta.0.x }),
        (_, Some(_), None) => Err(conflict(args, "eta", "one number, or r/g/b together with k")),
        (Some(f0), None, None) => Ok(Fresnel::Schlick { f0 }),
        (None, None, None) => Ok(Fresnel::MIRROR),
    }
}

/// The masking that `g` names.
pub(super) fn masking(args: &Args) -> Result<Masking, SubjectError> {
    Ok(if args.word("g")? == "separable" { Masking::Separable } else { Masking::Correlated })
}

/// The way of sampling that `sampling` names.
pub(super) fn sampling_of(args: &Args) -> Result<Sampling, SubjectError> {
    Ok(match args.word("sampling")? {
        "caps" => Sampling::Caps,
        "ndf" => Sampling::Ndf,
        _ => Sampling::Visible,
    })
}

/// `model` with everything else that a subject may say.
pub(super) fn build<N: Normals + 'static>(args: &Args, model: Microfacet<N>) -> Result<Box<dyn Bsdf>, SubjectError> {
    let compensation = match args.word("compensation")? {
        "kulla-conty" => Compensation::KullaConty,
        "turquin" => Compensation::Turquin,
        _ => Compensation::None,
    };
    let model =
        model.with_masking(masking(args)?).with_sampling(sampling_of(args)?)?.with_fresnel(reflectance(args)?)?;
    Ok(Box::new(model.with_compensation(compensation)?))
}

#[cfg(test)]
mod tests {
    use crate::bsdf::subject::parse;

    fn error(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn conflicting_parameters_are_one_clear_line() {
        assert_eq!(
            error("ggx:alpha=0.1,alpha_x=0.2"),
            "ggx: alpha_x = 0.2 is not allowed; allowed is either alpha or both of alpha_x and alpha_y"
        );
        assert_eq!(error("ggx:alpha_x=0.2"), "ggx: alpha_y is missing; it takes a number in [0.0001, 1]");
        assert_eq!(error("ggx:"), "ggx: alpha is missing; it takes a number in [0.0001, 1]");
        assert_eq!(error("ggx:alpha=0.1,f0=0.5,eta=1.5"), "ggx: f0 = 0.5 is not allowed; allowed is either f0 or eta");
        assert_eq!(error("beckmann:alpha=0.1,k=3"), "beckmann: k = 3 is not allowed; allowed is k together with eta");
        assert_eq!(
            error("ggx:alpha=0.1,eta=1.5/1.6/1.7"),
            "ggx: eta = 1.5/1.6/1.7 is not allowed; allowed is one number, or r/g/b together with k"
        );
    }

    #[test]
    fn what_a_distribution_cannot_do_is_one_clear_line() {
        assert_eq!(
            error("blinn:n=5,sampling=visible"),
            "blinn: sampling = visible is not allowed; allowed is one of ndf"
        );
        assert_eq!(
            error("beckmann:alpha=0.1,sampling=caps"),
            "beckmann: sampling = caps is not allowed; allowed is one of visible, ndf"
        );
        assert_eq!(
            error("ggx:alpha_x=0.1,alpha_y=0.2,compensation=turquin"),
            "ggx: compensation = turquin is not allowed; allowed is none where alpha_x and alpha_y differ"
        );
        assert_eq!(
            error("ggx:alpha=0.00001"),
            "ggx: alpha = 0.00001 is not allowed; allowed is a number in [0.0001, 1]"
        );
    }

    #[test]
    fn conflicts_do_not_hide_in_equal_values() {
        assert!(parse("ggx:alpha_x=0.1,alpha_y=0.1,compensation=turquin").is_ok());
        assert!(parse("ggx:alpha=0.1,f0=0.5,k=1").is_err());
    }
}
