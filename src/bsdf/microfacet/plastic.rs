//! A diffuse base under a rough dielectric coat.
//!
//! f = ρs F D G2 / (4 wo.z wi.z) + ρd T(wo.z) T(wi.z) / (π η² (1 − x Ri))      [1/sr]
//!
//! T(μ) is what a rough interface lets through at the cosine μ, Ri the average of what it reflects from inside, both
//! with the masking and the losses of the first term (module `transmittance`); x = ρd for `nonlinear`, else 1. They are
//! computed from the model itself, in tenths of a second, and not fitted; with `internal=mitsuba` Ri is the sum over 64
//! cosines that this renderer takes, about 1/64 too small. It never gains energy, since R + T ≤ 1 and
//! T_avg / η² is what the interface lets through from inside, at most 1 − Ri.
//!
//! `eta` is the index of the coat over the exterior, 1e-3 away from 1; `rho` = ρd, `reflect` = ρs. The specular lobe is
//! drawn with probability in proportion to 1 − T(wo.z), weighted by the mean colours.
//! # References
//! - Saunderson 1942, JOSA 32 (internal reflection); Walter et al. 2007, EGSR (the coat)
//! - Jakob et al. 2022, Mitsuba 3, plugin `roughplastic` (this combination of them)

use std::f64::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::DVec3;

use super::transmittance::{Transmittance, internal_reflectance, internal_reflectance_by_sum};
use super::{BeckmannNormals, GgxNormals, Masking, Microfacet, Normals, RoughDielectric, Sampling, entry};
use crate::bsdf::catalog::{Entry, Example};
use crate::bsdf::dielectric::REFLECT;
use crate::bsdf::plastic::{BASE, Base, COAT, INTERNAL, InternalReflectance, NONLINEAR, nonlinear, probabilities};
use crate::bsdf::subject::{Args, ParamSpec, SubjectError};
use crate::bsdf::{Bsdf, BsdfSample, Domain, Fresnel, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::discrete::pick;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

const MODEL: &str = "rough-plastic";
const TINT: Domain = Domain::Colour(0.0, 1.0);

/// A diffuse base under a rough dielectric coat with facets' normals `N`. See the module for f.
#[derive(Clone, Debug)]
pub struct RoughPlastic<N> {
    coat: Microfacet<N>,
    reflect: Rgb,
    base: Base,
    entering: Arc<Transmittance>,
}

impl<N: Normals> RoughPlastic<N> {
    /// A coat of index `eta` in [1e-3, 1e3] whose facets have these normals, the same in all azimuths, on a base of
    /// reflectance `rho` in [0, 1] per channel, linear.
    pub fn from_normals(
        normals: N,
        masking: Masking,
        eta: f64,
        rho: impl Into<Rgb>,
        internal: InternalReflectance,
    ) -> Result<Self, ParamError> {
        let rho = TINT.check_colour(MODEL, "rho", rho.into())?;
        let widths = normals.slope_widths();
        if widths.x != widths.y {
            return Err(ParamError::new(MODEL, "alpha_y", widths.y, "the same as alpha_x"));
        }
        let interface = RoughDielectric::from_normals(normals, eta)
            .map_err(|error| ParamError { model: MODEL, ..error })?
            .with_masking(masking);
        let entering = Arc::new(Transmittance::new(&interface));
        let internal = match internal {
            InternalReflectance::Exact => internal_reflectance(&interface),
            InternalReflectance::Mitsuba => internal_reflectance_by_sum(&interface),
        };
        let base = Base { rho, nonlinear: false, internal, inv_eta2: 1.0 / (eta * eta) };
        let coat = Microfacet::from_normals(interface.into_normals()).with_masking(masking);
        Ok(Self { coat: coat.with_fresnel(Fresnel::Dielectric { eta })?, reflect: Rgb::WHITE, base, entering })
    }

    /// The same with another way to sample the coat; an error where these normals do not have it.
    pub fn with_sampling(self, sampling: Sampling) -> Result<Self, ParamError> {
        Ok(Self { coat: self.coat.with_sampling(sampling)?, ..self })
    }

    /// The same with a factor on the specular reflection, in [0, 1] per channel.
    pub fn with_tint(self, reflect: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { reflect: TINT.check_colour(MODEL, "reflect", reflect.into())?, ..self })
    }

    /// The same where each internal return is coloured anew by the base.
    pub fn with_nonlinear(self, nonlinear: bool) -> Self {
        Self { base: Base { nonlinear, ..self.base }, ..self }
    }

    /// The same on another base, of reflectance `rho` in [0, 1] per channel.
    pub fn with_rho(self, rho: impl Into<Rgb>) -> Result<Self, ParamError> {
        let rho = TINT.check_colour(MODEL, "rho", rho.into())?;
        Ok(Self { base: Base { rho, ..self.base }, ..self })
    }

    fn probabilities(&self, wo: DVec3) -> [f64; 2] {
        probabilities(1.0 - self.entering.at(wo.z), self.reflect, self.base.rho)
    }
}

impl<N: Normals> Bsdf for RoughPlastic<N> {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if !super::above(wo, wi) {
            return Rgb::BLACK;
        }
        let through = self.entering.at(wo.z) * self.entering.at(wi.z);
        self.reflect * self.coat.eval(wo, wi) + self.base.reflectance() * (through * FRAC_1_PI)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if !super::above(wo, wi) {
            return 0.0;
        }
        let [specular, diffuse] = self.probabilities(wo);
        specular * self.coat.pdf(wo, wi) + diffuse * cosine_hemisphere_pdf(wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let above = Some(wo).filter(|wo| wo.z > 0.0)?;
        let (lobe, ..) = pick(&self.probabilities(above), u.lobe)?;
        let wi = if lobe == 0 { self.coat.draw(wo, u.dir) } else { cosine_hemisphere(u.dir) };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    fn normals(&self) -> Option<&dyn Normals> {
        self.coat.normals()
    }
}

/// `normals` with everything else that a subject may say.
fn build<N: Normals + 'static>(args: &Args, normals: N) -> Result<Box<dyn Bsdf>, SubjectError> {
    let (eta, rho) = (args.number("eta")?, args.colour("rho")?);
    let plastic = RoughPlastic::from_normals(normals, entry::masking(args)?, eta, rho, InternalReflectance::of(args)?)?;
    let plastic = if args.is_given("sampling") { plastic.with_sampling(entry::sampling_of(args)?)? } else { plastic };
    Ok(Box::new(plastic.with_tint(args.colour("reflect")?)?.with_nonlinear(nonlinear(args)?)))
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: MODEL,
    summary: "diffuse base under a rough coat: microfacets and what they let through",
    params: &[
        ParamSpec::new("alpha", super::ALPHA, "slope width of the coat"),
        BASE,
        COAT,
        ParamSpec::new("distribution", Domain::Word(&["ggx", "beckmann"]), "of the facets' normals").or("ggx"),
        entry::G,
        REFLECT,
        NONLINEAR,
        INTERNAL,
        ParamSpec::new("sampling", Domain::Word(&["caps", "visible", "ndf"]), "how normals are drawn").optional(),
    ],
    examples: &[
        Example::lawful("rough-plastic:alpha=0.3,rho=0.5/0.3/0.1"),
        Example::lawful("rough-plastic:alpha=0.1,rho=1,distribution=beckmann,g=separable"),
        Example::lawful("rough-plastic:alpha=0.05,rho=0.9,eta=1.9,nonlinear=true,reflect=0.8"),
    ],
    build: |args| {
        let alpha = args.number("alpha")?;
        match args.word("distribution")? {
            "beckmann" => build(args, BeckmannNormals::new(alpha, alpha)?),
            _ => build(args, GgxNormals::new(alpha, alpha)?),
        }
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::contract::{assert_sampled_exactly, assert_total};
    use crate::math::sphere::direction;

    fn ggx(alpha: f64, rho: Rgb, internal: InternalReflectance) -> RoughPlastic<GgxNormals> {
        let normals = GgxNormals::new(alpha, alpha).unwrap();
        RoughPlastic::from_normals(normals, Masking::Separable, 1.5, rho, internal).unwrap()
    }

    #[test]
    fn obeys_the_contract() {
        let plastic = ggx(0.3, Rgb::grey(0.5), InternalReflectance::Exact);
        assert_total(&plastic);
        assert_total(&ggx(1e-4, Rgb::WHITE, InternalReflectance::Exact));
        assert_sampled_exactly(&plastic, &[1.0, 0.5, 0.05]);
    }

    /// `roughplastic` (ggx, alpha .3, int_ior 1.5, ext_ior 1, diffuse_reflectance .5 .2 .8) in Mitsuba 3.9.1, scalar_rgb:
    /// (θo, φo, θi, φi) in degrees, f linear, f nonlinear (first channel), pdf.
    const MITSUBA: [([f64; 4], [f64; 3], f64, f64); 4] = [
        ([30.0, 10.0, 40.0, 200.0], [0.152103241, 0.0879614219, 0.216245051], 0.124124656, 0.303394228),
        ([60.0, 0.0, 50.0, 170.0], [0.212794947, 0.153790835, 0.271799047], 0.187057413, 0.38769868),
        ([80.0, 0.0, 80.0, 180.0], [5.21252531, 5.17091627, 5.25413401], 5.19437565, 1.37097502),
        ([10.0, 0.0, 85.0, 90.0], [0.087777223, 0.0389972115, 0.136557235], 0.0664994382, 0.027678363),
    ];

    #[test]
    fn f_and_pdf_are_those_of_another_renderer() {
        let plastic = ggx(0.3, Rgb::new(0.5, 0.2, 0.8), InternalReflectance::Mitsuba);
        for ([theta_o, phi_o, theta_i, phi_i], linear, nonlinear, pdf) in MITSUBA {
            let at = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
            let (wo, wi) = (at(theta_o, phi_o), at(theta_i, phi_i));
            // T is interpolated there between 64 cosines.
            let tol = 1e-3;
            let f = plastic.eval(wo, wi);
            for (ours, theirs) in f.to_array().into_iter().zip(linear) {
                assert!((ours / theirs - 1.0).abs() < tol, "{theta_o} {theta_i}: {ours} against {theirs}");
            }
            let coloured = plastic.clone().with_nonlinear(true).eval(wo, wi).0.x;
            assert!((coloured / nonlinear - 1.0).abs() < tol, "{theta_o} {theta_i}: {coloured} against {nonlinear}");
            let density = plastic.pdf(wo, wi);
            assert!((density / pdf - 1.0).abs() < tol, "{theta_o} {theta_i}: {density} against {pdf}");
        }
    }

    #[test]
    fn a_smooth_coat_is_the_limit() {
        let rough = ggx(1e-4, Rgb::grey(0.5), InternalReflectance::Exact);
        let smooth = crate::bsdf::Plastic::new(1.5, 0.5).unwrap();
        let (wo, wi) = (direction(0.5, 0.0), direction(1.0, 1.0));
        let (a, b) = (rough.eval(wo, wi).0.x, smooth.eval(wo, wi).0.x);
        // The tails of slopes of 1e-4, and the accuracy of T and Ri.
        assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    }

    #[test]
    fn unequal_widths_are_refused() {
        let normals = GgxNormals::new(0.1, 0.2).unwrap();
        let error =
            RoughPlastic::from_normals(normals, Masking::Separable, 1.5, 0.5, InternalReflectance::Exact).unwrap_err();
        assert_eq!(error.to_string(), "rough-plastic: alpha_y = 0.2 is not allowed; allowed is the same as alpha_x");
    }
}
