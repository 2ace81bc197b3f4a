//! Microfacet models: a distribution of visible normals, Smith masking, Fresnel reflection.
//!
//! f = F(wo·m) D(m) G2(wo, wi) / (4 wo.z wi.z)      [1/sr],  m = (wo + wi) / |wo + wi|
//!
//! D is the distribution of normals, ∫ D(m) m.z dm = 1. With Smith's Λ and the projected area σ(w) = w.z (1 + Λ(w)) of
//! the microsurface, G1(w) = w.z / σ(w) and
//! - correlated masking: G2 = 1 / (1 + Λ(wo) + Λ(wi)),  G2 / (4 wo.z wi.z) = 1 / 4(σo wi.z + σi wo.z − wo.z wi.z)
//! - separable masking: G2 = G1(wo) G1(wi),             G2 / (4 wo.z wi.z) = 1 / (4 σo σi)
//!
//! No cosine is left to divide by: f is finite and exact to the horizon. Since wo·m = |wo + wi| / 2, the half vector
//! is never normalised. Densities of `wi`:
//! - visible normals:  D(m) max(wo·m, 0)/σo · 1/(4 wo·m) = D(m) / (4 σo) = G1(wo) D(m) / (4 wo.z)
//! - all normals:      D(m) m.z / (4 wo·m)
//!
//! and a normal that reflects `wo` below the horizon is a lost draw. With compensation (module `energy`)
//! - Kulla-Conty:  f + Fms L(wo.z) L(wi.z) / (π Lavg), L = 1 − E the energy that one bounce of F = 1 loses
//! - Turquin:      f (1 + F(1) L(wo.z) / E(wo.z)), which is not reciprocal
//! # References
//! - Walter et al. 2007, EGSR (the model); Heitz 2014, JCGT 3(2) (masking, correlated and separable; projected area)
//! - Kulla & Conty 2017, SIGGRAPH course; Turquin 2019, "Practical multiple scattering compensation"

use std::fmt;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::{Bsdf, BsdfSample, Density, Domain, Fresnel, ParamError, Uniforms};
use crate::math::color::Rgb;
use crate::sampling::discrete::pick;

mod beckmann;
mod blinn;
mod dielectric;
mod energy;
mod entry;
mod ggx;
mod plastic;
mod transmittance;

pub use beckmann::{Beckmann, BeckmannNormals};
pub use blinn::{Blinn, BlinnNormals};
pub use dielectric::RoughDielectric;
pub use ggx::{Ggx, GgxNormals};
pub use plastic::RoughPlastic;

pub(super) use beckmann::ENTRY as BECKMANN;
pub(super) use blinn::ENTRY as BLINN;
pub(super) use dielectric::ENTRY as ROUGH_DIELECTRIC;
pub(super) use ggx::ENTRY as GGX;
pub(super) use plastic::ENTRY as ROUGH_PLASTIC;

use energy::LossTable;

/// Whether both directions are above the horizon; false for NaN.
#[inline]
fn above(wo: DVec3, wi: DVec3) -> bool {
    wo.z > 0.0 && wi.z > 0.0
}

/// The domain of slope widths.
const ALPHA: Domain = Domain::Closed(1e-4, 1.0);

/// A distribution of microfacet normals with its Smith masking function, in the local frame (n = +z).
pub trait Normals: fmt::Debug + Send + Sync {
    /// D(m) [1/sr], with ∫ D(m) m.z dm = 1 over the hemisphere; 0 for m.z ≤ 0.
    ///
    /// `m` may have any positive length: only its direction counts.
    fn d(&self, m: DVec3) -> f64;

    /// Smith's Λ(w) ≥ 0 for w.z > 0, so that G1 = 1 / (1 + Λ).
    fn lambda(&self, w: DVec3) -> f64;

    /// The masking function G1(w) in [0, 1]; 0 for w.z ≤ 0. It is the share of normals seen from `w` that is not hidden.
    fn g1(&self, w: DVec3) -> f64 {
        if w.z > 0.0 { 1.0 / (1.0 + self.lambda(w)) } else { 0.0 }
    }

    /// σ(w) = ∫ D(m) max(w·m, 0) dm = w.z (1 + Λ(w)) for w.z > 0: the area of the microsurface that `w` sees, hidden
    /// parts included, per area of the surface.
    fn projected_area(&self, w: DVec3) -> f64 {
        w.z * (1.0 + self.lambda(w))
    }

    /// Draws a normal, of any positive length, with density D(m) m.z.
    fn sample_all(&self, u: DVec2) -> DVec3;

    /// Draws a normal, of any positive length, by one of the methods in [`samplings`](Self::samplings): with density D(m) m.z by
    /// [`Sampling::Ndf`], else D(m) max(wo·m, 0) / σ(wo).
    fn sample(&self, by: Sampling, wo: DVec3, u: DVec2) -> DVec3 {
        let _ = (by, wo);
        self.sample_all(u)
    }

    /// The methods of sampling that [`sample`](Self::sample) knows, the best first.
    fn samplings(&self) -> &'static [Sampling] {
        &[Sampling::Ndf]
    }

    /// The widths of the distribution of slopes along x and y: normals within this angle of +z carry most of D.
    fn slope_widths(&self) -> DVec2;

    /// The model's name in the catalog, for errors.
    fn model(&self) -> &'static str;
}

/// How the masking of `wo` and that of `wi` go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Masking {
    /// Both depend on the height of the same facet: G2 = 1 / (1 + Λ(wo) + Λ(wi)).
    #[default]
    Correlated,
    /// Independently: G2 = G1(wo) G1(wi), darker.
    Separable,
}

/// How the microfacet normal of a sample is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Among the normals that `wo` sees (Heitz 2018 for GGX, by exact inversion for Beckmann).
    Visible,
    /// Among the normals that `wo` sees, by spherical caps (Dupuy & Benyoub 2023). GGX only.
    Caps,
    /// Among all normals, by D(m) m.z.
    Ndf,
}

impl Sampling {
    /// The word for it in a subject.
    const fn word(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Caps => "caps",
            Self::Ndf => "ndf",
        }
    }

    /// The same if `normals` know it, else the error on behalf of `model`.
    fn known_to(self, normals: &dyn Normals, model: &'static str) -> Result<Self, ParamError> {
        let known = normals.samplings();
        if known.contains(&self) {
            return Ok(self);
        }
        let words: Vec<_> = known.iter().map(|s| s.word()).collect();
        Err(ParamError::new(model, "sampling", self.word(), format!("one of {}", words.join(", "))))
    }
}

/// What is done about the light that is scattered more than once between facets, which f alone loses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compensation {
    /// Nothing.
    #[default]
    None,
    /// A second lobe L(wo.z) L(wi.z) carries it: reciprocal, and for F = 1 the albedo is 1.
    KullaConty,
    /// The lobe is scaled: for F = 1 the albedo is 1, but f is not reciprocal, and gains energy with the light fixed.
    Turquin,
}

/// A microfacet model with normals `N`. See the module for f and the densities.
#[derive(Clone, Debug)]
pub struct Microfacet<N> {
    normals: N,
    masking: Masking,
    sampling: Sampling,
    /// None stands for F = 1, which then costs nothing.
    fresnel: Option<Fresnel>,
    compensator: Option<Compensator>,
    /// Multiplies f.
    tint: Rgb,
}

/// What compensation adds to a model.
#[derive(Clone, Debug)]
struct Compensator {
    kind: Compensation,
    losses: Arc<LossTable>,
    /// Kulla-Conty: Fms / (π Lavg). Turquin: F(1).
    factor: Rgb,
    /// Kulla-Conty: the largest channel of Fms.
    strength: f64,
}

impl<N: Normals> Microfacet<N> {
    /// The model with these normals, F = 1, correlated masking, the best sampling and no compensation.
    pub fn from_normals(normals: N) -> Self {
        let sampling = normals.samplings().first().copied().unwrap_or(Sampling::Ndf);
        Self { normals, masking: Masking::Correlated, sampling, fresnel: None, compensator: None, tint: Rgb::WHITE }
    }

    /// The same with this reflectance of the facets.
    pub fn with_fresnel(mut self, fresnel: Fresnel) -> Result<Self, ParamError> {
        let fresnel = fresnel.validated(self.normals.model())?;
        self.fresnel = (!fresnel.is_mirror()).then_some(fresnel);
        self.compensator = self.compensator.take().map(|c| Compensator::new(c.kind, c.losses, fresnel));
        Ok(self)
    }

    /// The same with f multiplied by `tint` in [0, 1] per channel.
    pub fn with_tint(mut self, tint: impl Into<Rgb>) -> Result<Self, ParamError> {
        self.tint = Domain::Colour(0.0, 1.0).check_colour(self.normals.model(), "tint", tint.into())?;
        Ok(self)
    }

    /// The same with this masking. Computes the table of losses afresh where there is compensation.
    pub fn with_masking(mut self, masking: Masking) -> Self {
        self.masking = masking;
        if let Some(old) = self.compensator.take() {
            self.compensator = Some(self.compensated_by(old.kind));
        }
        self
    }

    /// The same with another way to sample; an error where these normals do not have it.
    pub fn with_sampling(mut self, sampling: Sampling) -> Result<Self, ParamError> {
        self.sampling = sampling.known_to(&self.normals, self.normals.model())?;
        Ok(self)
    }

    /// The same with this compensation, which takes some hundredths of a second to tabulate.
    ///
    /// The table holds one albedo per polar angle: an error where slope widths differ along x and y.
    pub fn with_compensation(mut self, compensation: Compensation) -> Result<Self, ParamError> {
        let widths = self.normals.slope_widths();
        let word = match compensation {
            Compensation::None => {
                self.compensator = None;
                return Ok(self);
            }
            Compensation::KullaConty => "kulla-conty",
            Compensation::Turquin => "turquin",
        };
        if widths.x != widths.y {
            let allowed = "none where alpha_x and alpha_y differ";
            return Err(ParamError::new(self.normals.model(), "compensation", word, allowed));
        }
        self.compensator = Some(self.compensated_by(compensation));
        Ok(self)
    }

    fn compensated_by(&self, kind: Compensation) -> Compensator {
        let losses = Arc::new(LossTable::new(&self.normals, self.masking));
        Compensator::new(kind, losses, self.fresnel.unwrap_or(Fresnel::MIRROR))
    }

    /// The mirror image of `wo` in a normal drawn for the specular lobe; it may lie below the horizon.
    #[allow(clippy::inline_always, reason = "as for the sampling of GGX itself")]
    #[inline(always)]
    fn draw(&self, wo: DVec3, u: DVec2) -> DVec3 {
        let m = self.normals.sample(self.sampling, wo, u);
        m * (2.0 * wo.dot(m) / m.length_squared()) - wo
    }

    /// G2(wo, wi) / (4 wo.z wi.z) [1/sr].
    #[inline]
    fn visibility(masking: Masking, area_o: f64, area_i: f64, wo: DVec3, wi: DVec3) -> f64 {
        match masking {
            Masking::Correlated => 0.25 / (area_o * wi.z + area_i * wo.z - wo.z * wi.z),
            Masking::Separable => 0.25 / (area_o * area_i),
        }
    }

    /// D(h) over the density of `wi` of the specular lobe, from the projected area of `wo` and h = wo + wi.
    #[inline]
    fn d_per_pdf(&self, area_o: f64, h: DVec3) -> f64 {
        match self.sampling {
            Sampling::Visible | Sampling::Caps => 4.0 * area_o,
            Sampling::Ndf => 2.0 * h.length_squared() / h.z,
        }
    }

    /// F at half the angle between two directions, from their sum h: |h| is twice the cosine.
    #[inline]
    fn reflectance(&self, h: DVec3) -> Rgb {
        self.fresnel.map_or(Rgb::WHITE, |fresnel| fresnel.eval(0.5 * h.length()))
    }

    /// Draws from the mixture of the specular lobe and that of compensation. Out of line: the model without compensation
    /// does not pay for it.
    #[inline(never)]
    fn sample_compensated(&self, compensator: &Compensator, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let share = compensator.share(wo.z, compensator.losses.loss(wo.z), self.fresnel.as_ref());
        let (lobe, ..) = pick(&[1.0 - share, share], u.lobe)?;
        let wi = if lobe == 0 { self.draw(wo, u.dir) } else { compensator.losses.sample(u.dir) };
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }

    /// What f and the density of the specular lobe are made of. For directions above the horizon.
    #[inline]
    fn terms(&self, wo: DVec3, wi: DVec3) -> Terms {
        let h = wo + wi;
        let (area_o, area_i) = (self.normals.projected_area(wo), self.normals.projected_area(wi));
        let visibility = Self::visibility(self.masking, area_o, area_i, wo, wi);
        Terms { h, d: self.normals.d(h), visibility, d_per_pdf: self.d_per_pdf(area_o, h) }
    }
}

/// f = F(h) · d · visibility, and the density d / d_per_pdf, of the specular lobe.
#[derive(Clone, Copy, Debug)]
struct Terms {
    h: DVec3,
    d: f64,
    visibility: f64,
    d_per_pdf: f64,
}

impl Terms {
    #[inline]
    fn single(&self) -> f64 {
        // The product overflows only where both cosines are below 1e-290; there d may also be 0, and the product NaN.
        if self.d > 0.0 { (self.d * self.visibility).min(f64::MAX) } else { 0.0 }
    }

    #[inline]
    fn pdf(&self) -> f64 {
        if self.d > 0.0 { self.d / self.d_per_pdf } else { 0.0 }
    }
}

impl Compensator {
    fn new(kind: Compensation, losses: Arc<LossTable>, fresnel: Fresnel) -> Self {
        let average_loss = losses.average();
        let f_avg = fresnel.average();
        // Light that leaves after k ≥ 2 bounces: F_avg² E_avg Σ (F_avg L_avg)^j, as a share of what F = 1 would lose.
        let fms = f_avg.map(|f| f * f * (1.0 - average_loss) / (1.0 - f * average_loss));
        let factor = match kind {
            Compensation::Turquin => fresnel.eval(1.0),
            _ if average_loss > 0.0 => fms * (std::f64::consts::FRAC_1_PI / average_loss),
            _ => Rgb::BLACK,
        };
        Self { kind, losses, factor, strength: fms.max_channel() }
    }

    /// The probability of drawing from Kulla and Conty's lobe, given the cosine of `wo`: its share of the albedo, with
    /// the specular lobe's reflectance taken at the angle of `wo`.
    fn share(&self, mu_o: f64, loss_o: f64, fresnel: Option<&Fresnel>) -> f64 {
        if self.kind == Compensation::Turquin || self.factor.is_black() {
            return 0.0;
        }
        let multiple = self.strength * loss_o;
        let single = fresnel.map_or(1.0, |fresnel| fresnel.eval(mu_o).max_channel()) * (1.0 - loss_o);
        if multiple > 0.0 { multiple / (multiple + single) } else { 0.0 }
    }

    /// f of the whole model from that of the specular lobe.
    fn f(&self, mu_o: f64, mu_i: f64, f: Rgb) -> Rgb {
        let loss_o = self.losses.loss(mu_o);
        match self.kind {
            Compensation::Turquin => f * (Rgb::WHITE + self.factor * (loss_o / (1.0 - loss_o))),
            _ => f + self.factor * (loss_o * self.losses.loss(mu_i)),
        }
    }

    /// Density of the whole model from that of the specular lobe.
    fn pdf(&self, mu_o: f64, mu_i: f64, pdf: f64, fresnel: Option<&Fresnel>) -> f64 {
        if self.kind == Compensation::Turquin {
            return pdf;
        }
        let share = self.share(mu_o, self.losses.loss(mu_o), fresnel);
        (1.0 - share) * pdf + share * self.losses.pdf(mu_i, self.losses.loss(mu_i))
    }
}

impl<N: Normals> Bsdf for Microfacet<N> {
    #[inline]
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if !above(wo, wi) {
            return Rgb::BLACK;
        }
        let terms = self.terms(wo, wi);
        let f = self.reflectance(terms.h) * terms.single();
        match &self.compensator {
            None => f * self.tint,
            Some(compensator) => compensator.f(wo.z, wi.z, f) * self.tint,
        }
    }

    #[inline]
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if !above(wo, wi) {
            return 0.0;
        }
        let h = wo + wi;
        let d = self.normals.d(h);
        let pdf = if d > 0.0 { d / self.d_per_pdf(self.normals.projected_area(wo), h) } else { 0.0 };
        match &self.compensator {
            None => pdf,
            Some(compensator) => compensator.pdf(wo.z, wi.z, pdf, self.fresnel.as_ref()),
        }
    }

    #[inline]
    fn eval_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        if self.compensator.is_some() || !above(wo, wi) {
            return (self.eval(wo, wi), self.pdf(wo, wi));
        }
        let terms = self.terms(wo, wi);
        (self.tint * self.reflectance(terms.h) * terms.single(), terms.pdf())
    }

    #[inline]
    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if !above(wo, wo) {
            return None;
        }
        if let Some(compensator) = &self.compensator {
            return self.sample_compensated(compensator, wo, u);
        }
        let wi = self.draw(wo, u.dir);
        if !above(wo, wi) {
            return None;
        }
        let terms = self.terms(wo, wi);
        let pdf = terms.pdf();
        // f cosθ / density, without D: it cancels.
        let weight = self.tint * self.reflectance(terms.h) * (terms.visibility * terms.d_per_pdf * wi.z);
        (pdf > 0.0).then_some(BsdfSample { wi, weight, density: Density::SolidAngle(pdf) })
    }

    /// True for facets of F = 1 with compensation.
    fn claims_lossless(&self) -> bool {
        self.fresnel.is_none() && self.compensator.is_some() && self.tint == Rgb::WHITE
    }

    fn normals(&self) -> Option<&dyn Normals> {
        Some(&self.normals)
    }
}

#[cfg(test)]
mod tests;
