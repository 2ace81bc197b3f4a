//! `whitefurnace sample`: draws with the model's own sampler, as CSV.
//!
//! A lost draw is a row with weight 0 and all other fields empty, so that the mean of a weight column estimates the
//! albedo.

use std::io::Write;

use super::Status;
use super::job::Sample;
use crate::bsdf::Density;
use crate::math::sphere::angles;
use crate::report::table::exact;
use crate::sampling::stream::{stream, uniforms};

pub(super) fn run(job: &Sample, out: &mut dyn Write) -> anyhow::Result<Status> {
    writeln!(out, "wi_x,wi_y,wi_z,theta_deg,phi_deg,weight_r,weight_g,weight_b,pdf")?;
    // One stream for all draws: the first rows are the same for every n.
    let mut rng = stream(job.seed, 0, 0);
    for _ in 0..job.n {
        let Some(sample) = job.subject.bsdf.sample(job.wo, uniforms(&mut rng)) else {
            writeln!(out, ",,,,,0,0,0,")?;
            continue;
        };
        let (w, [r, g, b]) = (sample.wi, sample.weight.to_array());
        let (theta, phi) = angles(w);
        let numbers = [w.x, w.y, w.z, theta.to_degrees(), phi.to_degrees(), r, g, b].map(exact).join(",");
        match sample.density {
            Density::SolidAngle(pdf) => writeln!(out, "{numbers},{}", exact(pdf))?,
            Density::Dirac(probability) => writeln!(out, "{numbers},dirac:{}", exact(probability))?,
        }
    }
    Ok(Status::Pass)
}
