//! `weak_white_furnace`: microfacets seen from any direction cover exactly the area of the surface.
//!
//! For a distribution D with Smith masking G1, over the *whole sphere* of light directions,
//! ∫ G1(wo) D(h) / (4 |wo.z|) dwi = 1. In terms of the normals h that is ∫ G1 D(m) max(0, wo·m) dm / wo.z = 1, which is
//! how it is integrated here; and ∫ D(m) m.z dm = 1.
//!
//! # References
//! - Heitz 2014, JCGT 3(2), "Understanding the masking-shadowing function" (the weak white furnace test)

use glam::DVec3;

use super::check::{Check, Outcome};
use super::laws::{above, polar_angles};
use crate::bsdf::microfacet::Normals;
use crate::integrate::Integral;
use crate::math::chart::Chart;
use crate::math::cubature::Mesh;

/// Deviation put down to rounding: the rational Beckmann G1, the smallest error known to matter, makes 3·10⁻³.
const ROUNDING: f64 = 1e-6;

/// ∫ D(m) m.z dm and ∫ G1(w) D(m) max(0, w·m) dm / w.z for a direction above the horizon: both 1 for a sound model.
pub(crate) fn furnaces(normals: &dyn Normals, w: DVec3) -> [Integral<f64>; 2] {
    let (tol, max_evals) = (1e-8, 2_000_000);
    let upright = |m: DVec3| [normals.d(m) * m.z];
    let masking = normals.g1(w) / w.z;
    let visible = |m: DVec3| [masking * normals.d(m) * w.dot(m).max(0.0)];
    [(DVec3::Z, &upright as &dyn Fn(DVec3) -> [f64; 1]), (w, &visible)].map(|(seen_from, f)| {
        let mut mesh = Mesh::new(Chart::visible_normals(seen_from), f);
        mesh.refine(tol, max_evals);
        let error = mesh.error();
        Integral { value: mesh.value()[0], error, resolved: error <= ROUNDING, evals: mesh.evals() }
    })
}

/// The check over several directions; inconclusive for a model without a distribution of normals.
pub(crate) fn check(normals: Option<&dyn Normals>, seed: u64) -> Check {
    let mut check = Check::new("weak_white_furnace");
    check.bound = ROUNDING;
    let Some(normals) = normals else {
        return check.inconclusive_here("the model shows no distribution of microfacet normals");
    };
    let mut worst = 0.0_f64;
    let angles = polar_angles(8, 3, seed);
    for (i, &theta) in angles.iter().enumerate() {
        let w = above(theta.min(1.570), 0.7 * i as f64);
        for (what, integral) in ["∫ D cosθ", "∫ G1 D <w·m> / cosθ"].into_iter().zip(furnaces(normals, w)) {
            if !integral.resolved {
                return check.inconclusive(
                    w,
                    &format!("{what} could not be resolved: {} ± {:.1e}", integral.value, integral.error),
                );
            }
            let gap = ((integral.value - 1.0).abs() - integral.error).max(0.0);
            if gap > worst || check.worst.is_none() {
                worst = gap;
                check.worst = Some((w, w));
                check.detail = format!(
                    "{what} = {:.9} at {:.2} degrees, at the worst of {} directions",
                    integral.value,
                    theta.to_degrees(),
                    angles.len()
                );
            }
        }
    }
    check.statistic = worst;
    check.outcome = if worst <= ROUNDING { Outcome::Pass } else { Outcome::Fail };
    check.detects.insert("masking", 2.0 * ROUNDING);
    check
}
