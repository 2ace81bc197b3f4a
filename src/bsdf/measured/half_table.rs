//! The sampler of a lobe that is known only as a function of tanθ_h: a table of half vectors beside a cosine lobe.
//!
//! The table is linear in s = ln(1 + tan²θ_h / w²), w the width of the peak: proportional to tan² within the peak, so that
//! the density is smooth at the pole, and to ln tan outside, so that a slow tail is resolved as well. With q(s) the density
//! in s and φ_h uniform,
//!
//! p(h) = q(s) / (π cos³θ_h (w² + tan²θ_h)),   p(wi) = p(h) / (4 cosθ_d)      [1/sr]

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::bsdf::half_vector::HalfVector;
use crate::bsdf::{Bsdf, BsdfSample, Uniforms};
use crate::sampling::discrete;
use crate::sampling::tabulated::PiecewiseLinear;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

/// Cells of the table: steps of less than 5 % in tan, which a linear density follows to within a per cent.
const CELLS: usize = 1024;
/// The table's end in tan²θ_h, at 0.06 degrees from the horizon; the cosine lobe covers what is beyond.
const MAX_TAN2: f64 = 1e6;
/// Neither lobe is drawn less often than this, so that no error of the estimate below makes a weight explode.
const RARE: f64 = 0.1;

/// Draws directions for a fitted model.
#[derive(Clone, Debug)]
pub(super) struct HalfTable {
    width2: f64,
    table: Option<PiecewiseLinear>,
    /// The probability of the half vectors; that of the cosine lobe is the rest.
    p_half: f64,
}

impl HalfTable {
    /// For the lobe `peak(tan²θ_h)` = F D, F some mean, of f = diffuse / π + F D G / (π cosθ_i cosθ_o), whose peak is
    /// `width` wide in tanθ_h.
    pub(super) fn new(width: f64, diffuse: f64, peak: impl Fn(f64) -> f64) -> Self {
        let width2 = width * width;
        let end = (MAX_TAN2 / width2).ln_1p();
        let values: Vec<f64> = (0..=CELLS)
            .map(|i| {
                let tan2 = width2 * (end * i as f64 / CELLS as f64).exp_m1();
                // D cosθ_h dh = D cos⁴θ_h π (w² + tan²) ds
                peak(tan2) * PI * (width2 + tan2) / (1.0 + tan2).powi(2)
            })
            .collect();
        // At normal incidence f cosθ_i = F D / π and dwi = 4 cosθ_h dh.
        let lobe = 4.0 / PI * values.iter().sum::<f64>() * end / CELLS as f64;
        let table = PiecewiseLinear::new(&values, end);
        let p_half = if table.is_some() { (lobe / (lobe + diffuse)).clamp(RARE, 1.0 - RARE) } else { 0.0 };
        Self { width2, table, p_half }
    }

    fn half_vector_pdf(&self, h: HalfVector) -> f64 {
        let Some(table) = &self.table else { return 0.0 };
        let tan2 = h.tan2();
        let q = table.sample_pdf((tan2 / self.width2).ln_1p());
        if q > 0.0 { q / (PI * h.cos_h.powi(3) * (self.width2 + tan2)) } else { 0.0 }
    }

    pub(super) fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let Some(h) = HalfVector::new(wo, wi) else { return 0.0 };
        let cosine = cosine_hemisphere_pdf(wi);
        let half = (self.half_vector_pdf(h) / (4.0 * h.cos_d)).min(f64::MAX);
        cosine + (half - cosine) * self.p_half
    }

    /// A draw for `model`, whose pdf is [`Self::pdf`].
    pub(super) fn sample(&self, model: &impl Bsdf, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let (lobe, _, _) = discrete::pick(&[1.0 - self.p_half, self.p_half], u.lobe)?;
        let wi = match &self.table {
            Some(table) if lobe == 1 => {
                let tan = (self.width2 * table.sample(u.dir.x).exp_m1()).sqrt();
                let (sin, cos) = (TAU * u.dir.y).sin_cos();
                HalfVector::reflect(wo, tan * DVec2::new(cos, sin))
            }
            _ => cosine_hemisphere(u.dir),
        };
        BsdfSample::new(wi, model.eval(wo, wi), self.pdf(wo, wi))
    }
}
