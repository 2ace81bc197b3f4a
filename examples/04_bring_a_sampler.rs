//! Three rungs: a closure, a model with `eval`, a model with its own sampler, and how the sheet catches a wrong pdf.
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::error::Error;
use std::f64::consts::{FRAC_1_PI, TAU};

use whitefurnace::math::sphere::direction_mu;
use whitefurnace::prelude::*;

/// f = 0.6 (wo.z wi.z) · 3/(2π): brightest when seen and lit from above.
fn f(wo: DVec3, wi: DVec3) -> Rgb {
    Rgb::grey(if wo.z > 0.0 && wi.z > 0.0 { 0.6 * 1.5 * FRAC_1_PI * wo.z * wi.z } else { 0.0 })
}

/// Sampled in proportion to f cos: the density is 3 cos²/(2π), so that cos = u^(1/3).
#[derive(Debug)]
struct Spot {
    /// What the pdf is multiplied by: 1 is right.
    pdf_scale: f64,
}

impl Bsdf for Spot {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        f(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 && wi.z > 0.0 { self.pdf_scale * 3.0 / TAU * wi.z * wi.z } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let wi = direction_mu((1.0 - u.dir.x).cbrt(), TAU * u.dir.y);
        // Black below the horizon, with density 0 there: `new` makes a lost draw of it.
        BsdfSample::new(wi, f(wo, wi), self.pdf(wo, wi))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let suite = Suite { effort: Effort::Quick, ..Suite::default() };
    let closure = suite.run(&FnBsdf::new("spot", f));
    let right = suite.run(&Spot { pdf_scale: 1.0 });
    let wrong = suite.run(&Spot { pdf_scale: 1.02 });
    for (name, sheet) in [("closure", &closure), ("own sampler", &right), ("pdf 2 % too large", &wrong)] {
        println!("{name:<18} {}", sheet.outcome());
    }
    assert_eq!(closure.outcome(), Outcome::Pass, "{closure:#?}");
    assert_eq!(right.outcome(), Outcome::Pass, "{right:#?}");
    let mass = wrong.check("pdf_mass").ok_or("on the sheet")?;
    println!("{}", mass.detail);
    assert_eq!(mass.outcome, Outcome::Fail);
    Ok(())
}
