//! The integrator states its error, and closed forms show that it keeps its word.
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::error::Error;

use whitefurnace::math::sphere::direction_mu;
use whitefurnace::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let hemisphere = Hemisphere { tol: 1e-9, ..Hemisphere::default() };

    println!("GGX, alpha = 1, F = 1, against 1 - mu ln(1 + 1/mu)");
    let ggx = Ggx::new(1.0)?;
    for mu in [0.01_f64, 0.1, 0.5, 1.0] {
        let truth = 1.0 - mu * (1.0 + 1.0 / mu).ln();
        let albedo = hemisphere.albedo(&ggx, Side::Eye, direction_mu(mu, 0.3));
        let gap = (albedo.value.max_channel() - truth).abs();
        println!("  mu = {mu:<5} {:.12} ± {:.0e}, off by {gap:.0e}", albedo.value.max_channel(), albedo.error);
        // The stated bound, and one part in 1e15 for the closed form's own rounding.
        assert!(albedo.resolved && gap <= albedo.error + 1e-15);
    }

    println!("Phong, n = 100, (n+2)/2π, against its closed form at every angle");
    let phong = Phong::new(100.0, 0.0, 1.0, PhongNorm::AlbedoNPlus2)?;
    for mu in [0.01, 0.1, 0.5, 1.0] {
        let wo = direction_mu(mu, 0.0);
        let truth = phong.albedo(wo).ok_or("Phong has a closed form")?.max_channel();
        let albedo = hemisphere.albedo(&phong, Side::Eye, wo);
        let gap = (albedo.value.max_channel() - truth).abs();
        println!("  mu = {mu:<5} {:.12} ± {:.0e}, off by {gap:.0e}", albedo.value.max_channel(), albedo.error);
        assert!(albedo.resolved && gap <= albedo.error + 1e-13, "the closed form is good to 1e-13");
    }
    Ok(())
}
