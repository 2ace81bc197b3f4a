//! Maps from the unit square to directions, as triples `x`, `x_pdf`, `x_inv`.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::{DVec2, DVec3};

/// Maps the unit square to the hemisphere so that p(w) = cosθ / π.
///
/// `u` in [0, 1)². The pole is `u.x = 0`. Inverse: [`cosine_hemisphere_inv`].
pub fn cosine_hemisphere(u: DVec2) -> DVec3 {
    let (r, phi) = (u.x.sqrt(), TAU * u.y);
    // 1 − u.x, not 1 − r²: exact near the horizon, where r² has already been rounded.
    DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u.x).sqrt())
}

/// cosθ / π [1/sr] above the horizon, 0 below.
pub fn cosine_hemisphere_pdf(w: DVec3) -> f64 {
    w.z.max(0.0) * FRAC_1_PI
}

/// The `u` that [`cosine_hemisphere`] maps to `w`.
pub fn cosine_hemisphere_inv(w: DVec3) -> DVec2 {
    DVec2::new(w.x * w.x + w.y * w.y, turn(w))
}

/// The azimuth of `w` as a fraction of a full turn, in [0, 1).
fn turn(w: DVec3) -> f64 {
    let t = w.y.atan2(w.x) / TAU;
    if t < 0.0 { (t + 1.0).min(1.0 - f64::EPSILON / 2.0) } else { t }
}
