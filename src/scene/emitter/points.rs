//! Lights without a surface: points, spots and parallel light.

use glam::DVec3;

use super::{LightSample, Target};
use crate::bsdf::Density;
use crate::math::color::Rgb;
use crate::scene::ray::NO_TRIANGLE;

/// The irradiance I / d² from a point.
pub(super) fn point(p: DVec3, position: DVec3, intensity: Rgb) -> Option<LightSample> {
    let way = position - p;
    let distance2 = way.length_squared();
    let wi = way / distance2.sqrt();
    // The target has no normal: the end of the shadow ray is moved back along itself.
    wi.is_finite().then(|| LightSample {
        wi,
        radiance: intensity / distance2,
        density: Density::Dirac(1.0),
        target: Some(Target { point: position, normal: -wi, triangles: [NO_TRIANGLE; 2] }),
    })
}

/// The same within a cone about `axis`, falling linearly in the angle from `beam` to `cutoff`.
pub(super) fn spot(p: DVec3, position: DVec3, axis: DVec3, intensity: Rgb, cone: (f64, f64)) -> Option<LightSample> {
    let mut sample = point(p, position, intensity)?;
    let (beam, cutoff) = cone;
    let angle = (-sample.wi).angle_between(axis);
    let share = if angle <= beam { 1.0 } else { (cutoff - angle) / (cutoff - beam) };
    sample.radiance = sample.radiance * share;
    (angle < cutoff || angle <= beam).then_some(sample)
}

/// Parallel light from `towards`.
pub(super) fn directional(towards: DVec3, irradiance: Rgb) -> LightSample {
    LightSample { wi: towards, radiance: irradiance, density: Density::Dirac(1.0), target: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_falls_linearly_in_the_angle() {
        let at = |degrees: f64| {
            let p = crate::math::sphere::direction(degrees.to_radians(), 0.3) * 2.0;
            spot(p, DVec3::ZERO, DVec3::Z, Rgb::WHITE, (0.2, 0.4)).map_or(0.0, |s| s.radiance.0.x)
        };
        assert!((at(0.0) - 0.25).abs() < 1e-15 && (at(11.0) - 0.25).abs() < 1e-15);
        assert!((at(0.3_f64.to_degrees()) - 0.125).abs() < 1e-12);
        assert_eq!(at(23.0), 0.0);
    }
}
