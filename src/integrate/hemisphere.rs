//! Deterministic integrals over directions that come with an error bound and say when they do not meet it.
//!
//! The sphere is two hemispheres (module `half`), and what follows is done in each where a model can be lit; Dirac lobes
//! are added to albedos as they are found (module `dirac`).
//!
//! The integrand may have its lobe anywhere and of any width. Three charts are tried: polar angles about the normal
//! (diffuse reflection), about the mirror direction (Phong-like lobes) and of the half vector (microfacet lobes); for
//! transmission, two about the refracted direction, or, where all is refracted by facets, two of the refracting normal.
//! Each
//! is shown every peak that any of them, or the model's own sampler, has come across, and refines around it; the chart
//! with the smallest error is then refined to the tolerance, and another one until its value agrees. The error stated is
//! the cubature's own bound plus the difference of the two charts, times a factor of safety. Where no two of the three agree, the result is marked
//! unresolved. What this can miss is a lobe far from the normal, the mirror direction and the direction
//! itself, narrower than the charts' initial nodes, and never drawn by the model's sampler.

use std::f64::consts::{PI, TAU};
use std::ops::Add;

use glam::DVec3;
use rayon::prelude::*;

use super::dirac::{DiracLobe, dirac_lobes, way_back};
use super::half::Half;
use crate::bsdf::{Bsdf, Density};
use crate::math::color::Rgb;
use crate::math::cubature::Mesh;
use crate::math::quadrature::adaptive;
use crate::math::sphere::{direction_mu, rotate_z};
use crate::sampling::stream::{stream, uniform, uniforms};

/// How many draws of the model's sampler are shown to the charts as possible places of lobes.
const HINT_DRAWS: u64 = 16;

/// The stated error in multiples of cubature's bound and the charts' difference. A crease that runs aslant through the cells
/// of both charts has made the sum of the two fall short fourfold (Phong, n = 1, at μ = 0.03).
const SAFETY: f64 = 8.0;
/// How often a disagreement of all charts is followed up before the result is called unresolved.
const ROUNDS: usize = 4;
/// Work that a confirming chart may take, in multiples of what the confirmed one has taken, and at the least.
const PROPORTION: u64 = 10;
const LEAST_WORK: u64 = 100_000;

/// Largest tolerance of an albedo that enters an average.
const COARSEST: f64 = 1e-3;
/// Most azimuths over which an albedo is averaged.
const MOST_AZIMUTHS: u32 = 256;

/// Which direction is held fixed while the other runs over the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// `wo` is fixed: what a backward path tracer and the usual white furnace measure.
    Eye,
    /// `wi` is fixed: where the energy of one beam of light goes.
    Light,
}

/// The value of an integral with a bound on its error.
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct Integral<T = Rgb> {
    /// The integral.
    pub value: T,
    /// A bound on its error (of every channel). NaN where the integrand is not finite.
    pub error: f64,
    /// Whether the error meets the tolerance, tol · max(1, value), and all charts agree.
    pub resolved: bool,
    /// How often the model was evaluated.
    pub evals: u64,
}

impl<T> Integral<T> {
    pub(crate) fn map<U>(self, f: impl FnOnce(T) -> U) -> Integral<U> {
        Integral { value: f(self.value), error: self.error, resolved: self.resolved, evals: self.evals }
    }
}

impl<T: Add<Output = T>> Integral<T> {
    /// The sum of two, resolved if both are.
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            error: self.error + other.error,
            resolved: self.resolved && other.resolved,
            evals: self.evals + other.evals,
        }
    }
}

/// A deterministic integrator over the hemisphere, or over two of them where a model transmits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hemisphere {
    /// Largest allowed error: absolute below a value of 1, relative above.
    pub tol: f64,
    /// Most evaluations of the model for one direction.
    pub max_evals: u64,
}

impl Default for Hemisphere {
    fn default() -> Self {
        Self { tol: 1e-6, max_evals: 4_000_000 }
    }
}

impl Hemisphere {
    /// The default with another tolerance.
    pub fn with_tol(tol: f64) -> Self {
        Self { tol, ..Self::default() }
    }

    /// Directional albedo ∫ f |cos| dω over the free direction, with the direction `w` fixed on either side: what is
    /// reflected and what is transmitted, Dirac lobes included.
    ///
    /// With the light fixed it is the share of the beam's power that leaves, ∫ f(v, w) η_v²/η_w² |v.z| dv, for f that
    /// carries L / η². The Dirac lobes by which it leaves are found from `w`, and their weights on the way back.
    pub fn albedo(&self, bsdf: &dyn Bsdf, side: Side, w: DVec3) -> Integral {
        let hints = hints(bsdf, w);
        let index = |w: DVec3| if w.z < 0.0 { bsdf.eta() } else { 1.0 };
        let mut total = Integral { value: dirac_albedo(bsdf, side, w), error: 0.0, resolved: true, evals: 0 };
        for half in Half::all(bsdf, w) {
            let f = |v: DVec3| {
                let free = half.free(v);
                let value = match side {
                    Side::Eye => bsdf.eval(w, free),
                    Side::Light => bsdf.eval(free, w) * (index(free) / index(w)).powi(2),
                };
                (value * v.z.abs()).to_array()
            };
            total = total.plus(self.over(&half, &hints, &f).1.map(Rgb::from));
        }
        total
    }

    /// ∫ pdf(wo, wi) dwi over the sphere: 1 less the probabilities of a lost draw and of Dirac lobes.
    pub fn pdf_mass(&self, bsdf: &dyn Bsdf, wo: DVec3) -> Integral<f64> {
        let hints = hints(bsdf, wo);
        let mut total = Integral { value: 0.0, error: 0.0, resolved: true, evals: 0 };
        for half in Half::all(bsdf, wo) {
            let f = |v: DVec3| [bsdf.pdf(wo, half.free(v))];
            total = total.plus(self.over(&half, &hints, &f).1.map(|[mass]| mass));
        }
        total
    }

    /// Hemispherical average 2 ∫ a(μ) μ dμ of the albedo, over azimuth as well where the model is not isotropic.
    ///
    /// The mean over azimuth is that of evenly spaced ones, doubled until it settles: of a smooth periodic function it
    /// converges faster than any power.
    pub fn average(&self, bsdf: &dyn Bsdf, side: Side) -> Integral {
        // The fourth integral is the share of the error that the albedos themselves contribute.
        let ring = |phi: f64| {
            let mut evals = 0;
            // μ = s²: crowds the nodes towards grazing, where albedos turn.
            let integrand = |s: f64| {
                let weight = 4.0 * s * s * s;
                // What weighs little may be known less well.
                let inner = Self { tol: (0.3 * self.tol / weight).min(COARSEST), ..*self };
                let a = inner.albedo(bsdf, side, direction_mu(s * s, phi));
                evals += a.evals;
                let [r, g, b] = a.value.to_array();
                [r, g, b, a.error].map(|x| weight * x)
            };
            let q = adaptive(integrand, &[0.0, 0.1, 0.4, 1.0], 0.3 * self.tol, 200);
            Ring { sum: q.value, error: q.error, evals }
        };
        let mut total = ring(0.0);
        let mut mean = total.mean(1);
        let mut azimuths = 1;
        let mut settled = 0.0;
        if !is_isotropic(bsdf) {
            settled = f64::INFINITY;
            while azimuths < MOST_AZIMUTHS && settled > 0.3 * self.tol {
                let between = |i| ring(TAU * (f64::from(i) + 0.5) / f64::from(azimuths));
                let rings: Vec<Ring> = (0..azimuths).into_par_iter().map(between).collect();
                for ring in &rings {
                    total.add(ring);
                }
                azimuths *= 2;
                let finer = total.mean(azimuths);
                // Two azimuths may agree by symmetry alone.
                settled = if azimuths < 8 { f64::INFINITY } else { (finer - mean).0.abs().max_element() };
                mean = finer;
            }
        }
        let error = (total.error + total.sum[3]) / f64::from(azimuths) + settled;
        let resolved = error <= self.tol * mean.max_channel().max(1.0);
        Integral { value: mean, error, resolved, evals: total.evals }
    }

    /// ∫ f(v) dω over the hemisphere, for an `f` ≥ 0 whose lobes follow the fixed direction `w`; `hints` are further
    /// directions where it may be large.
    pub fn integrate<const N: usize>(
        &self,
        w: DVec3,
        hints: &[DVec3],
        f: &dyn Fn(DVec3) -> [f64; N],
    ) -> Integral<[f64; N]> {
        if w.z <= 0.0 {
            return Integral { value: [0.0; N], error: 0.0, resolved: true, evals: 0 };
        }
        self.over(&Half::reflected(w), hints, f).1
    }

    /// ∫ f dω over one half, of an `f` of directions that are seen in it upright, and the mesh on which it was found.
    /// `hints` are free directions as they are.
    pub fn over<'a, const N: usize>(
        &self,
        half: &Half,
        hints: &[DVec3],
        f: &'a dyn Fn(DVec3) -> [f64; N],
    ) -> (Mesh<'a, N>, Integral<[f64; N]>) {
        let hints: Vec<DVec3> = hints.iter().filter_map(|&hint| half.seen(hint)).collect();
        let mut meshes = half.charts(|v| largest(&f(v)) > 0.0).map(|c| Mesh::new(c, f));
        self.show_peaks(&mut meshes, &hints, half, f);
        let mut agreement = f64::INFINITY;
        for _ in 0..ROUNDS {
            meshes.sort_by(|a, b| a.error().total_cmp(&b.error()));
            let [best, second, third] = &mut meshes;
            let target = 0.25 / SAFETY * self.tol * largest(&best.value()).max(1.0);
            best.refine(target, self.max_evals);
            agreement = self.confirm(best, second, target);
            if agreement <= target {
                break;
            }
            let other = self.confirm(best, third, target);
            agreement = agreement.min(other);
            if agreement <= target || best.evals() >= self.max_evals {
                break;
            }
            let against = gap(second, third);
            if against <= target && second.error() <= target {
                // Two of three: the one that claimed to be best was blind to something.
                std::mem::swap(best, second);
                agreement = against;
                break;
            }
            // Somebody is blind. What has come into sight since may tell; else look everywhere.
            let spent = |meshes: &[Mesh<'_, N>]| meshes.iter().map(Mesh::evals).sum::<u64>();
            let before = spent(&meshes);
            self.show(&mut meshes, &[]);
            if spent(&meshes) == before {
                meshes[0].halve_all(self.max_evals);
            }
        }

        let evals = meshes.iter().map(Mesh::evals).sum();
        // A NaN that any chart has met is in the integrand, whichever chart is taken.
        let poison: f64 = meshes.iter().map(|mesh| 0.0 * mesh.value().iter().sum::<f64>()).sum();
        let [best, ..] = meshes;
        let value = best.value();
        let error = SAFETY * (best.error() + agreement) + poison;
        let resolved = error <= self.tol * largest(&value).max(1.0);
        (best, Integral { value, error, resolved, evals })
    }

    /// Refines `other` until its value agrees with that of `best` to `target`, or it is as sure of its own, or its work is
    /// out of proportion; returns by how much they differ.
    fn confirm<const N: usize>(&self, best: &Mesh<'_, N>, other: &mut Mesh<'_, N>, target: f64) -> f64 {
        let limit = (PROPORTION * best.evals() + LEAST_WORK).min(self.max_evals);
        loop {
            let apart = gap(best, other);
            let error = other.error();
            let hopeless = error.is_nan() || error <= target || other.evals() >= limit;
            if apart <= target || hopeless {
                return apart;
            }
            other.refine((0.125 * error).max(target), limit);
        }
    }

    /// Shows every chart the peaks that the others, the hints and the usual directions have.
    fn show_peaks<const N: usize>(
        &self,
        meshes: &mut [Mesh<'_, N>],
        hints: &[DVec3],
        half: &Half,
        f: &dyn Fn(DVec3) -> [f64; N],
    ) {
        let w = half.fixed();
        // Layers along the horizon hide between its edge and the nodes next to it.
        let low = [0.1, 1e-2, 1e-3, 1e-4].into_iter().flat_map(|mu| [0.0, 0.5 * PI, PI].map(|turn| (mu, turn)));
        let azimuth = w.y.atan2(w.x);
        let usual = [half.centre(), w, DVec3::Z].into_iter().chain(hints.iter().copied());
        let usual = usual.chain(low.map(|(mu, turn)| direction_mu(mu, azimuth + turn)));
        let witnesses: Vec<(DVec3, f64)> = usual.map(|v| (v, largest(&f(v)))).collect();
        self.show(meshes, &witnesses);
    }

    /// Shows every chart these values of the integrand, and the largest that each of the charts has seen.
    fn show<const N: usize>(&self, meshes: &mut [Mesh<'_, N>], witnesses: &[(DVec3, f64)]) {
        let peaks: Vec<(DVec3, f64)> = meshes.iter().map(Mesh::peak).collect();
        for mesh in meshes {
            for &(v, value) in witnesses.iter().chain(&peaks) {
                if v.z > 0.0 && value.is_finite() {
                    mesh.witness(v, value, self.max_evals);
                }
            }
        }
    }
}

/// Averages over polar angle, summed over azimuths.
struct Ring {
    /// Red, green, blue, and the error bound of the albedos.
    sum: [f64; 4],
    error: f64,
    evals: u64,
}

impl Ring {
    fn add(&mut self, other: &Self) {
        for (a, b) in self.sum.iter_mut().zip(other.sum) {
            *a += b;
        }
        self.error += other.error;
        self.evals += other.evals;
    }

    fn mean(&self, azimuths: u32) -> Rgb {
        let [r, g, b, _] = self.sum;
        Rgb::new(r, g, b) / f64::from(azimuths)
    }
}

/// The largest difference between the values of two meshes; NaN if any value is.
fn gap<const N: usize>(a: &Mesh<'_, N>, b: &Mesh<'_, N>) -> f64 {
    let differences = a.value().into_iter().zip(b.value()).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, |worst, d| if d <= worst { worst } else { d })
}

fn largest<const N: usize>(values: &[f64; N]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// What Dirac lobes add to the albedo.
fn dirac_albedo(bsdf: &dyn Bsdf, side: Side, w: DVec3) -> Rgb {
    let share = |lobe: &DiracLobe| match side {
        Side::Eye => lobe.albedo(),
        Side::Light => way_back(bsdf, w, lobe).map_or(Rgb::BLACK, |back| back.albedo()),
    };
    dirac_lobes(bsdf, w).iter().map(share).sum()
}

/// Directions in which the model's own sampler finds lobes.
pub fn hints(bsdf: &dyn Bsdf, w: DVec3) -> Vec<DVec3> {
    let mut rng = stream(0, 0, 0);
    let draws = (0..HINT_DRAWS).filter_map(|_| bsdf.sample(w, uniforms(&mut rng)));
    draws.filter(|s| matches!(s.density, Density::SolidAngle(_))).map(|s| s.wi).filter(|wi| wi.is_finite()).collect()
}

/// Whether f depends on the two azimuths only through their difference, on 64 random pairs to 1 in 10⁶.
///
/// The tolerance leaves room for the rounding of a turned half vector in a lobe of width 10⁻⁴.
pub fn is_isotropic(bsdf: &dyn Bsdf) -> bool {
    let mut rng = stream(0, 1, 0);
    (0..64).all(|_| {
        let mut random = || direction_mu(0.02 + 0.98 * uniform(&mut rng), TAU * uniform(&mut rng));
        let (wo, wi) = (random(), random());
        let wi = bsdf.sample(wo, uniforms(&mut rng)).map_or(wi, |s| s.wi);
        let turn = 1.0 + 5.0 * uniform(&mut rng);
        let (f, g) = (bsdf.eval(wo, wi), bsdf.eval(rotate_z(wo, turn), rotate_z(wi, turn)));
        (f - g).0.abs().max_element() <= 1e-6 * f.max_channel()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Lambert;
    use crate::math::sphere::direction;

    /// A needle of exponent 10⁶ about a direction of its own, with and without a sampler that knows of it.
    #[derive(Debug)]
    struct Needle {
        axis: DVec3,
        sampled: bool,
    }

    impl Bsdf for Needle {
        fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
            let x = (-0.5 * (wi - self.axis).length_squared()).max(-1.0);
            let lobe = (1e6 * x.ln_1p()).exp();
            Rgb::grey(if wo.z > 0.0 && wi.z > 0.0 { lobe } else { 0.0 })
        }

        fn sample(&self, _: DVec3, u: crate::bsdf::Uniforms) -> Option<crate::bsdf::BsdfSample> {
            let wi = if self.sampled { self.axis } else { crate::sampling::warp::cosine_hemisphere(u.dir) };
            crate::bsdf::BsdfSample::new(wi, Rgb::WHITE, 1.0)
        }
    }

    #[test]
    fn lambert_has_its_albedo_from_both_sides_and_on_average() {
        let rho = Rgb::new(0.2, 0.5, 0.9);
        let lambert = Lambert::new(rho).unwrap();
        let quadrature = Hemisphere::with_tol(1e-9);
        for w in [DVec3::Z, direction(1.0, 2.0), direction(PI / 2.0 - 1e-6, 0.0)] {
            for side in [Side::Eye, Side::Light] {
                let a = quadrature.albedo(&lambert, side, w);
                assert!(a.resolved && (a.value - rho).0.abs().max_element() <= a.error + 1e-14, "{a:?}");
            }
            let mass = quadrature.pdf_mass(&lambert, w);
            assert!(mass.resolved && (mass.value - 1.0).abs() <= mass.error + 1e-14);
        }
        let average = quadrature.average(&lambert, Side::Eye);
        assert!(average.resolved && (average.value - rho).0.abs().max_element() <= 1e-9);
    }

    /// A layer along the horizon, thinner than the distance from the last node of a coarse rule to the edge.
    #[derive(Debug)]
    struct Layer;

    impl Bsdf for Layer {
        fn eval(&self, _: DVec3, wi: DVec3) -> Rgb {
            Rgb::grey(if wi.z < 0.004 { 0.1 / wi.z } else { 0.0 })
        }
    }

    #[test]
    fn a_layer_along_the_horizon_is_not_confidently_missed() {
        for theta in [0.3, 1.0, 1.5] {
            let a = Hemisphere::with_tol(1e-5).albedo(&Layer, Side::Eye, direction(theta, 0.0));
            // ∫ 0.1 dω over cosθ < 0.004
            let exact = 0.1 * 2.0 * PI * 0.004;
            let honest = (a.value.0.x - exact).abs() <= a.error;
            assert!(honest, "{theta}: {a:?} {exact}");
        }
    }

    #[test]
    fn a_needle_that_the_sampler_knows_is_resolved() {
        let needle = Needle { axis: direction(0.4, 2.2), sampled: true };
        let a = Hemisphere::with_tol(1e-12).albedo(&needle, Side::Eye, direction(0.9, 0.1));
        // ∫ cos^n about the axis, times the cosine: the axial moment is 2π/(n + 2), tilted by 0.4.
        let exact = 2.0 * PI / (1e6 + 2.0) * 0.4_f64.cos();
        assert!(a.resolved && (a.value.0.x - exact).abs() <= a.error.max(1e-15), "{a:?} {exact}");
    }

    #[test]
    fn what_is_not_finite_or_too_dear_is_unresolved() {
        #[derive(Debug)]
        struct Rough;
        impl Bsdf for Rough {
            fn eval(&self, _: DVec3, wi: DVec3) -> Rgb {
                Rgb::grey(1.0 + (1e4 * wi.x).sin())
            }
        }
        let few = Hemisphere { tol: 1e-9, max_evals: 20_000 };
        assert!(!few.albedo(&Rough, Side::Eye, direction(0.5, 0.0)).resolved);
        let nan = Hemisphere::default().integrate(DVec3::Z, &[], &|w| [if w.z > 0.9 { f64::NAN } else { 1.0 }]);
        assert!(!nan.resolved && nan.error.is_nan());
    }
}
