//! Mistakes in what is drawn: f and density are the original's.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::flaw::flaws;
use crate::bsdf::{BsdfSample, Density, Uniforms};
use crate::math::color::Rgb;
use crate::math::sphere::{half_vector, mirror, reflect, rotate_z};

flaws! {
    /// Loses this share of the draws without saying so.
    Dropped(f64) {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            if u.dir.x < self.1 { None } else { self.0.sample(wo, u).map(|s| s.wi) }
        }
    }

    /// Never draws a patch that holds this share of the mass; draws elsewhere instead.
    Hole(f64) {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            let side = self.1.sqrt();
            let within = |x: f64, start: f64| (start..start + side).contains(&x);
            // Half a square away there is no hole.
            let hole = within(u.dir.x, 0.3) && within(u.dir.y, 0.6);
            let dir = if hole { (u.dir + DVec2::splat(0.5)).fract() } else { u.dir };
            self.0.sample(wo, Uniforms { dir, ..u }).map(|s| s.wi)
        }
    }

    /// Sends this share of the draws to the opposite azimuth, where a lobe has almost no density.
    Leak(f64) {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            // The lowest digits of one number decide, so that no region is favoured.
            let astray = (u.dir.x * 65_536.0).fract() < self.1;
            self.0.sample(wo, u).map(|s| if astray { rotate_z(s.wi, PI) } else { s.wi })
        }
    }

    /// Draws about axes that are turned by this angle, in radians, about the normal.
    Rotated(f64) {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, u).map(|s| rotate_z(s.wi, self.1))
        }
    }

    /// Right after averaging over the azimuth, and only then.
    OnlyOnAverage() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, u).map(|s| rotate_z(s.wi, TAU * u.lobe))
        }
    }

    /// Reflects about the half vector on the other side of the normal.
    MirroredHalfVector() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, u).map(|s| reflect(wo, mirror(half_vector(wo, s.wi))))
        }
    }

    /// For half of the half vectors the sign is wrong, and the direction points into the surface.
    UnflippedHalfVector() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            Some(if u.dir.y < 0.5 { s } else { BsdfSample { wi: -s.wi, ..s } })
        }
    }

    /// Keeps the draws that ended below the horizon.
    BelowTheHorizon() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let below = BsdfSample { wi: -wo, weight: Rgb::WHITE, density: Density::SolidAngle(1.0) };
            self.0.sample(wo, u).or((wo.z > 0.0).then_some(below))
        }
    }

    /// Draws again where a draw is lost, and does not scale the density up.
    Redrawn() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            // Steps by the golden ratio and its square: some of them is kept.
            let step = DVec2::new(0.618_033_988_749_894_9, 0.381_966_011_250_105_1);
            let mut tries = (0..64).map(|i| Uniforms { dir: (u.dir + f64::from(i) * step).fract(), ..u });
            tries.find_map(|u| self.0.sample(wo, u)).map(|s| s.wi)
        }
    }

    /// Draws only half of the azimuths.
    HalfTurn() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, Uniforms { dir: DVec2::new(u.dir.x, 0.5 * u.dir.y), ..u }).map(|s| s.wi)
        }
    }

    /// Forgets a square root: the radius of the disk is u instead of √u.
    MissingSquareRoot() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, Uniforms { dir: DVec2::new(u.dir.x * u.dir.x, u.dir.y), ..u }).map(|s| s.wi)
        }
    }

    /// Uses one random number for both coordinates.
    Correlated() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, Uniforms { dir: DVec2::splat(u.dir.x), ..u }).map(|s| s.wi)
        }
    }

    /// Uses the random number that has picked the lobe once more, without stretching it to [0, 1).
    ReusedUniform() {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, Uniforms { dir: DVec2::new(u.lobe, u.dir.y), ..u }).map(|s| s.wi)
        }
    }

    /// Picks lobes with other probabilities than the density knows: lobe^p for lobe.
    BiasedLobe(f64) {
        fn direction(&self, wo: DVec3, u: Uniforms) -> Option<DVec3> {
            self.0.sample(wo, Uniforms { lobe: u.lobe.powf(self.1), ..u }).map(|s| s.wi)
        }
    }

    /// Takes the logarithm of a uniform number that may be 0.
    NanAtZero() {
        fn draw(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
            let s = self.0.sample(wo, u)?;
            let ratio = u.dir.x.ln() / u.dir.x.ln();
            Some(BsdfSample { weight: s.weight * ratio, ..s })
        }
    }
}
