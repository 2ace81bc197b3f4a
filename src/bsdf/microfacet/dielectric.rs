//! A rough interface of two transparent media: microfacets that reflect and refract.
//!
//! With `wo` on the near side, η the index of the far side over the near one, m the facet's normal on the near side,
//! c_o = wo·m, F = F(c_o), and light carried as L / η²:
//! - reflection:    m ∝ wo + wi,           f = ρ F D(m) G2 / (4 |wo.z wi.z|),     J = dm/dwi = 1 / (4 c_o)
//! - transmission:  m ∝ ±(wo + η wi),      f = τ (1 − F) D(m) G2 c_o J / |wo.z wi.z|,  J = η² |wi·m| / |wo + η wi|²
//!
//! The first is the second with its own J: f = share · D · G2/|wo.z wi.z| · c_o J. A facet is drawn (visible normals by
//! default), then a lobe with probability F or 1 − F: pdf = share · p(m) J, so that F never is in the weight. Lost are
//! draws that end on the wrong side. Masking is 1 / (1 + Λo + Λi) or G1(wo) G1(wi) for both lobes, as pbrt and Cycles,
//! or Mitsuba, have it; what facets lose to each other is not given back: R + T < 1.
//!
//! `eta`, in [1e-3, 1e3] and 1e-3 away from 1, is the index of the interior (z < 0) over the exterior. Next to 1 the
//! lobe of transmission is a Dirac delta in all but name.
//! # References
//! - Walter, Marschner, Li & Torrance 2007, EGSR (eqs. 13-17, 20, 21), here without the η² of radiance
//! - Heitz 2014, JCGT 3(2) (masking); Stam 2001, EGWR (an earlier rough interface)

use glam::DVec3;

use super::{BeckmannNormals, GgxNormals, Masking, Microfacet, Normals, Sampling, entry};
use crate::bsdf::catalog::{Entry, Example};
use crate::bsdf::dielectric::{REFLECT, TRANSMIT, Tints};
use crate::bsdf::refraction::{ETA, relative};
use crate::bsdf::subject::{Args, ParamSpec, SubjectError};
use crate::bsdf::{Bsdf, BsdfSample, Density, Domain, Lobes, ParamError, Uniforms, fresnel};
use crate::math::color::Rgb;
use crate::math::sphere::{flip, refract};

const MODEL: &str = "rough-dielectric";
/// How near to 1 the index may be: the half vector wo + η wi of a straight path keeps 13 digits.
const LEAST_CONTRAST: f64 = 1e-3;

/// A rough interface of two dielectrics with facets' normals `N`. See the module for f and the density.
#[derive(Clone, Debug)]
pub struct RoughDielectric<N> {
    normals: N,
    eta: f64,
    masking: Masking,
    sampling: Sampling,
    tints: Tints,
}

impl<N: Normals> RoughDielectric<N> {
    /// Facets with these normals; `eta` in [1e-3, 1e3], not within 1e-3 of 1, is the index of the interior over the
    /// exterior. Correlated masking, the best sampling, no tints.
    pub fn from_normals(normals: N, eta: f64) -> Result<Self, ParamError> {
        let eta = ETA.check(MODEL, "eta", eta)?;
        if (eta - 1.0).abs() < LEAST_CONTRAST {
            let domain = format!("{ETA}, and at least {LEAST_CONTRAST} from 1: else take dielectric");
            return Err(ParamError::new(MODEL, "eta", eta, domain));
        }
        let sampling = normals.samplings().first().copied().unwrap_or(Sampling::Ndf);
        Ok(Self { normals, eta, masking: Masking::Correlated, sampling, tints: Tints::NONE })
    }

    /// The same with this masking.
    pub fn with_masking(self, masking: Masking) -> Self {
        Self { masking, ..self }
    }

    /// The same with another way to sample; an error where these normals do not have it.
    pub fn with_sampling(self, sampling: Sampling) -> Result<Self, ParamError> {
        Ok(Self { sampling: sampling.known_to(&self.normals, MODEL)?, ..self })
    }

    /// The same with factors on what is reflected and what is transmitted, in [0, 1] per channel.
    pub fn with_tints(self, reflect: impl Into<Rgb>, transmit: impl Into<Rgb>) -> Result<Self, ParamError> {
        Ok(Self { tints: Tints::new(MODEL, reflect.into(), transmit.into())?, ..self })
    }

    /// The facet that sends light from `wi` to `wo`, which lies above; `eta` is relative to the side of `wo`.
    #[inline]
    fn facet(&self, wo: DVec3, wi: DVec3, eta: f64) -> Option<Facet> {
        let reflects = wi.z > 0.0;
        // Along the normal, wo + η wi has the sign of 1 − η: cosθo − η cosθi = cosθo − √(η² − 1 + cos²θo).
        let m = if reflects {
            wo + wi
        } else if eta > 1.0 {
            -(wo + eta * wi)
        } else {
            wo + eta * wi
        };
        let length2 = m.length_squared();
        let unit = m / length2.sqrt();
        let (cos_o, cos_i) = (wo.dot(unit), wi.dot(unit).abs());
        if !(unit.z > 0.0 && cos_o > 0.0 && (reflects || wi.dot(unit) < 0.0)) {
            return None;
        }
        let d = Some(self.normals.d(m)).filter(|&d| d > 0.0)?;
        let (share, tint, jacobian) = if reflects {
            (fresnel::dielectric(eta, cos_o), self.tints.reflect, 0.25 / cos_o)
        } else {
            (fresnel::transmitted(eta, cos_o, cos_i), self.tints.transmit, eta * eta * cos_i / length2)
        };
        Some(Facet { d, cos_m: unit.z, cos_o, share, tint, jacobian })
    }

    /// D c_o over the density of the facet.
    #[inline]
    fn seen_per_pdf(&self, facet: &Facet, wo: DVec3) -> f64 {
        match self.sampling {
            Sampling::Visible | Sampling::Caps => self.normals.projected_area(wo),
            Sampling::Ndf => facet.cos_o / facet.cos_m,
        }
    }

    /// G2 / |wo.z wi.z|, with `wo` above.
    #[inline]
    fn visibility(&self, wo: DVec3, wi: DVec3) -> f64 {
        let wi = if wi.z < 0.0 { flip(wi) } else { wi };
        let (area_o, area_i) = (self.normals.projected_area(wo), self.normals.projected_area(wi));
        4.0 * Microfacet::<N>::visibility(self.masking, area_o, area_i, wo, wi)
    }

    /// What the facet with the unit normal `m` reflects and transmits of the light that `wo` sees, per solid angle of m:
    /// f |wi.z| dwi/dm of both lobes without tints. `wo` and `m` above; `eta` is relative to the side of `wo`.
    pub(super) fn shares_of(&self, wo: DVec3, m: DVec3, eta: f64) -> [f64; 2] {
        let c = wo.dot(m);
        if c <= 0.0 {
            return [0.0; 2];
        }
        let (f, seen) = (fresnel::dielectric(eta, c), self.normals.d(m) * c);
        let reflected = Some(2.0 * c * m - wo).filter(|wi| wi.z > 0.0);
        let refracted = refract(wo, m, eta).filter(|wi| wi.z < 0.0);
        [(f, reflected), (1.0 - f, refracted)]
            .map(|(share, wi)| wi.map_or(0.0, |wi| share * seen * self.visibility(wo, wi) * wi.z.abs()))
    }

    /// The facets' normals.
    pub(super) fn into_normals(self) -> N {
        self.normals
    }

    /// The index of the interior over the exterior.
    pub(super) fn index(&self) -> f64 {
        self.eta
    }

    /// Both directions as seen from the side of `wo`, and the index of the far side over the near one.
    #[inline]
    fn upright(&self, wo: DVec3, wi: DVec3) -> Option<(DVec3, DVec3, f64)> {
        let eta = relative(self.eta, wo);
        let (wo, wi) = if wo.z < 0.0 { (flip(wo), flip(wi)) } else { (wo, wi) };
        (wo.z > 0.0 && wi.z.abs() > 0.0).then_some((wo, wi, eta))
    }
}

/// A facet that connects two directions, and what f and the density are made of.
struct Facet {
    /// D(m).
    d: f64,
    cos_m: f64,
    cos_o: f64,
    /// F or 1 − F.
    share: f64,
    tint: Rgb,
    /// dm / dwi.
    jacobian: f64,
}

impl<N: Normals> Bsdf for RoughDielectric<N> {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let Some((wo, wi, eta)) = self.upright(wo, wi) else { return Rgb::BLACK };
        let Some(facet) = self.facet(wo, wi, eta) else { return Rgb::BLACK };
        let bare = facet.share * facet.d * facet.cos_o * facet.jacobian * self.visibility(wo, wi);
        // Overflows only where both cosines are below 1e-150.
        facet.tint * bare.min(f64::MAX)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let Some((wo, wi, eta)) = self.upright(wo, wi) else { return 0.0 };
        let Some(facet) = self.facet(wo, wi, eta) else { return 0.0 };
        facet.share * facet.d * facet.cos_o * facet.jacobian / self.seen_per_pdf(&facet, wo)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let below = wo.z < 0.0;
        let (wo, _, eta) = self.upright(wo, wo)?;
        let m = self.normals.sample(self.sampling, wo, u.dir).try_normalize()?;
        let c = Some(wo.dot(m)).filter(|&c| c > 0.0)?;
        let reflects = u.lobe < fresnel::dielectric(eta, c);
        let wi = if reflects { (2.0 * c * m - wo).try_normalize()? } else { refract(wo, m, eta)? };
        if reflects != (wi.z > 0.0) {
            return None;
        }
        let facet = self.facet(wo, wi, eta)?;
        let seen_per_pdf = self.seen_per_pdf(&facet, wo);
        let pdf = facet.share * facet.d * facet.cos_o * facet.jacobian / seen_per_pdf;
        // f |cosθi| / pdf: what is left after share, D, c_o and the Jacobian cancel.
        let weight = facet.tint * (self.visibility(wo, wi) * wi.z.abs() * seen_per_pdf);
        let wi = if below { flip(wi) } else { wi };
        (pdf > 0.0 && pdf.is_finite()).then_some(BsdfSample { wi, weight, density: Density::SolidAngle(pdf) })
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT.union(Lobes::TRANSMIT)
    }

    fn eta(&self) -> f64 {
        self.eta
    }

    fn normals(&self) -> Option<&dyn Normals> {
        Some(&self.normals)
    }
}

/// `normals` with everything else that a subject may say.
fn build<N: Normals + 'static>(args: &Args, normals: N) -> Result<Box<dyn Bsdf>, SubjectError> {
    let glass = RoughDielectric::from_normals(normals, args.number("eta")?)?.with_masking(entry::masking(args)?);
    let glass = if args.is_given("sampling") { glass.with_sampling(entry::sampling_of(args)?)? } else { glass };
    Ok(Box::new(glass.with_tints(args.colour("reflect")?, args.colour("transmit")?)?))
}

pub(in crate::bsdf) const ENTRY: Entry = Entry {
    name: MODEL,
    summary: "rough glass: microfacets that reflect F and refract 1 − F",
    params: &[
        entry::ALPHA_BOTH,
        entry::ALPHA_X,
        entry::ALPHA_Y,
        ParamSpec::new("eta", ETA, "index of refraction of the interior over the exterior, not 1").or("1.5"),
        ParamSpec::new("distribution", Domain::Word(&["ggx", "beckmann"]), "of the facets' normals").or("ggx"),
        entry::G,
        REFLECT,
        TRANSMIT,
        ParamSpec::new("sampling", Domain::Word(&["caps", "visible", "ndf"]), "how normals are drawn").optional(),
    ],
    examples: &[
        Example::lawful("rough-dielectric:alpha=0.3"),
        Example::lawful("rough-dielectric:alpha=0.1,eta=0.6667,g=separable"),
        Example::lawful("rough-dielectric:alpha=0.3,eta=1.33,distribution=beckmann,g=separable"),
        Example::lawful("rough-dielectric:alpha_x=0.1,alpha_y=0.4,transmit=0.9/0.6/0.3"),
        Example::lawful("rough-dielectric:alpha=0.001"),
    ],
    build: |args| {
        let alpha = entry::alphas(args)?;
        match args.word("distribution")? {
            "beckmann" => build(args, BeckmannNormals::new(alpha.x, alpha.y)?),
            _ => build(args, GgxNormals::new(alpha.x, alpha.y)?),
        }
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::contract::{assert_sampled_exactly, assert_total};
    use crate::math::sphere::direction;
    use crate::sampling::stream::{stream, uniforms};

    fn ggx(alpha: f64, eta: f64) -> RoughDielectric<GgxNormals> {
        RoughDielectric::from_normals(GgxNormals::new(alpha, alpha).unwrap(), eta).unwrap()
    }

    fn beckmann(alpha: f64, eta: f64) -> RoughDielectric<BeckmannNormals> {
        RoughDielectric::from_normals(BeckmannNormals::new(alpha, alpha).unwrap(), eta).unwrap()
    }

    #[test]
    fn total_at_the_edges() {
        for eta in [1.5, 0.7, 1.002, 1000.0] {
            assert_total(&ggx(0.3, eta));
            assert_total(&ggx(1e-4, eta).with_masking(Masking::Separable));
            assert_total(&beckmann(0.1, eta).with_sampling(Sampling::Ndf).unwrap());
        }
    }

    #[test]
    fn the_pdf_has_the_mass_that_is_not_lost() {
        assert_sampled_exactly(&beckmann(0.3, 1.5), &[1.0, 0.4, -0.3, -0.9]);
        assert_sampled_exactly(&ggx(0.01, 0.8), &[0.7, -0.2]);
    }

    #[test]
    fn weights_and_densities_are_those_of_eval_and_pdf() {
        for model in [ggx(0.3, 1.5), ggx(0.01, 1.5), ggx(0.3, 0.6).with_sampling(Sampling::Ndf).unwrap()] {
            let mut kept = [0; 2];
            for theta in [0.0, 0.8, 1.5, 1.7, 2.5, 3.0] {
                let wo = direction(theta, 0.4);
                let mut rng = stream(5, 0, 0);
                for s in (0..2000).filter_map(|_| model.sample(wo, uniforms(&mut rng))) {
                    kept[usize::from(s.wi.z * wo.z < 0.0)] += 1;
                    let (f, pdf) = (model.eval(wo, s.wi).0.x, model.pdf(wo, s.wi));
                    assert_eq!(s.density, Density::SolidAngle(pdf));
                    // Half vectors lose digits by 1/|η − 1| and by the width of the lobe.
                    let gap = (s.weight.0.x - f * s.wi.z.abs() / pdf).abs();
                    assert!(gap <= 1e-12 * s.weight.0.x, "{model:?} at {theta}: off by {gap}");
                }
            }
            assert!(kept[0] > 100 && kept[1] > 100, "{model:?}: {kept:?}");
        }
    }

    #[test]
    fn reciprocal_over_the_whole_sphere() {
        let model = beckmann(0.5, 1.5);
        let mut rng = stream(6, 0, 0);
        let mut crossed = 0;
        for i in 0..4000 {
            let wo = direction(0.001 * f64::from(i % 3140), 0.7);
            let Some(s) = model.sample(wo, uniforms(&mut rng)) else { continue };
            let square = |w: DVec3| if w.z < 0.0 { 1.5 * 1.5 } else { 1.0 };
            let (there, back) = (model.eval(wo, s.wi).0.x, model.eval(s.wi, wo).0.x);
            let gap = there / square(s.wi) - back / square(wo);
            // Next to grazing facets 1 − F has lost the digits of a small cosine.
            assert!(gap.abs() <= 1e-10 * there, "{wo} {}: {there} {back}", s.wi);
            crossed += u32::from(s.wi.z * wo.z < 0.0);
        }
        assert!(crossed > 1000);
    }

    #[test]
    fn next_to_no_roughness_fresnels_shares_come_out() {
        let model = ggx(1e-4, 1.5);
        for theta in [0.3, 1.0, 1.3, 2.5, 2.9] {
            let wo = direction(theta, 0.0);
            let f = fresnel::dielectric(relative(1.5, wo), wo.z.abs());
            let mut rng = stream(7, 0, 0);
            let (mut reflected, mut transmitted) = (0.0, 0.0);
            let n = 40_000;
            for s in (0..n).filter_map(|_| model.sample(wo, uniforms(&mut rng))) {
                *(if s.wi.z * wo.z > 0.0 { &mut reflected } else { &mut transmitted }) += s.weight.0.x / f64::from(n);
            }
            // Five standard errors, and what a slope of 1e-4 with long tails changes.
            let tol = 5.0 * (f * (1.0 - f) / f64::from(n)).sqrt() + 1e-3;
            assert!((reflected - f).abs() <= tol && (transmitted - (1.0 - f)).abs() <= tol, "{theta}: {reflected} {f}");
        }
    }

    /// f and pdf of `roughdielectric` (int_ior 1.5, ext_ior 1) in Mitsuba 3.9.1, variant scalar_rgb: (θo, φo, θi, φi)
    /// in degrees of our `wo` and `wi`, f, pdf. It carries radiance: where light crosses, f · (η_i/η_o)² is ours.
    type Published = [([f64; 4], f64, f64); 6];
    const MITSUBA_GGX: Published = [
        ([30.0, 10.0, 40.0, 200.0], 0.0452002156, 0.0351654813),
        ([30.0, 10.0, 155.0, 185.0], 4.82119037, 9.87920094),
        ([60.0, 0.0, 140.0, 170.0], 2.74286997, 4.80135345),
        ([150.0, 20.0, 30.0, 200.0], 3.22563695, 1.25079107),
        ([150.0, 20.0, 160.0, 210.0], 0.0406962045, 0.0383555666),
        ([130.0, 0.0, 80.0, 170.0], 4.10032976, 0.47048381),
    ];
    const MITSUBA_BECKMANN: Published = [
        ([30.0, 10.0, 40.0, 200.0], 0.0993722871, 0.0761235878),
        ([60.0, 0.0, 140.0, 170.0], 3.0884582, 5.32326652),
        ([150.0, 20.0, 30.0, 200.0], 0.0391741549, 0.0150781386),
        ([120.0, 0.0, 120.0, 180.0], 7.95774698, 3.97887349),
        ([80.0, 0.0, 80.0, 180.0], 23.5990956, 4.26641464),
        ([130.0, 0.0, 80.0, 170.0], 5.10046981, 0.409822166),
    ];
    const MITSUBA_ANISOTROPIC_GGX: Published = [
        ([30.0, 10.0, 40.0, 200.0], 0.0575487831, 0.0442976579),
        ([30.0, 10.0, 155.0, 185.0], 0.506325746, 1.03312051),
        ([60.0, 0.0, 140.0, 170.0], 2.58803947, 4.4721179),
        ([150.0, 20.0, 30.0, 200.0], 0.17237946, 0.0665008351),
        ([120.0, 0.0, 120.0, 180.0], 7.84057236, 3.94947124),
        ([130.0, 0.0, 80.0, 170.0], 1.3469872, 0.114946434),
    ];

    fn assert_as_published(model: &dyn Bsdf, published: &Published, tol: f64) {
        for &([theta_o, phi_o, theta_i, phi_i], f, pdf) in published {
            let at = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
            let (wo, wi) = (at(theta_o, phi_o), at(theta_i, phi_i));
            let square = |w: DVec3| if w.z < 0.0 { 2.25 } else { 1.0 };
            let ours = model.eval(wo, wi).0.x * square(wo) / square(wi);
            let density = model.pdf(wo, wi);
            assert!((ours / f - 1.0).abs() < tol, "{model:?} {theta_o} {theta_i}: {ours} against {f}");
            assert!((density / pdf - 1.0).abs() < tol, "{model:?} {theta_o} {theta_i}: {density} against {pdf}");
        }
    }

    #[test]
    fn f_and_pdf_are_those_of_another_renderer() {
        let separable = |model: RoughDielectric<GgxNormals>| model.with_masking(Masking::Separable);
        // Single precision, and next to the critical angle 1 − F amplifies it.
        assert_as_published(&separable(ggx(0.3, 1.5)), &MITSUBA_GGX, 2e-4);
        let normals = GgxNormals::new(0.1, 0.4).unwrap();
        let anisotropic = RoughDielectric::from_normals(normals, 1.5).unwrap();
        assert_as_published(&separable(anisotropic), &MITSUBA_ANISOTROPIC_GGX, 2e-4);
        // Its masking of Beckmann is the rational fit, up to 0.3 % off for each direction.
        assert_as_published(&beckmann(0.2, 1.5).with_masking(Masking::Separable), &MITSUBA_BECKMANN, 6e-3);
    }

    #[test]
    fn an_index_of_1_is_refused_with_advice() {
        let error = RoughDielectric::from_normals(GgxNormals::new(0.1, 0.1).unwrap(), 1.0).unwrap_err();
        assert!(error.to_string().starts_with("rough-dielectric: eta = 1 is not allowed"), "{error}");
    }
}
