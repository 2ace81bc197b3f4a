//! Mistakes in f.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::flaw::flaws;
use crate::math::color::Rgb;

flaws! {
    /// Forgets 1/π: π f.
    MissingPi() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * PI
        }
    }

    /// Divides by π twice: f / π.
    ExtraPi() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * FRAC_1_PI
        }
    }

    /// Returns f cosθ_i, as if every renderer left the cosine to the model.
    CosineInEval() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * wi.z.max(0.0)
        }
    }

    /// f / (2 cosθ_i): half of the light comes back for every view, but an unbounded share of a grazing beam.
    DividedByCosine() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * (0.5 / wi.z.max(1e-100))
        }
    }

    /// f times a constant.
    Gain(f64) {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * self.1
        }
    }

    /// f times a constant where one of the cosines is below the second number.
    GainAtGrazing(f64, f64) {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * if wo.z.min(wi.z) < self.2 { self.1 } else { 1.0 }
        }
    }

    /// f (1 + ε cosθ_i): swapping eye and light changes the value by less than ε.
    Asymmetric(f64) {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            self.0.eval(wo, wi) * (1.0 + self.1 * wi.z)
        }
    }

    /// Normalises the tangential part of wo, which is 0 at the normal.
    NanAtTheNormal() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            let tangent = DVec3::new(wo.x, wo.y, 0.0);
            self.0.eval(wo, wi) * (tangent / tangent.length()).length()
        }
    }

    /// Divides by the sine of the angle between the directions, √(1 − cos²): NaN where the cosine rounds to 1.
    NanAtCosineOne() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            let cos = wo.dot(wi);
            let sin = (1.0 - cos * cos).sqrt();
            self.0.eval(wo, wi) * (sin.recip() * sin)
        }
    }

    /// A fitted correction that undershoots where both directions graze.
    Negative() {
        fn f(&self, wo: DVec3, wi: DVec3) -> Rgb {
            let f = self.0.eval(wo, wi);
            if wo.z.max(wi.z) < 0.05 { f * -0.01 } else { f }
        }
    }

    /// States a closed form of the albedo that is off by a factor.
    WrongAlbedo(f64) {
        fn closed_albedo(&self, wo: DVec3) -> Option<Rgb> {
            self.0.albedo(wo).map(|albedo| albedo * self.1)
        }
    }

    /// Claims to lose nothing.
    FalseClaim() {
        fn claim(&self) -> bool {
            true
        }
    }
}
