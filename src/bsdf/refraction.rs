//! The two sides of an interface: the domain of indices of refraction, and which of them is seen from where.

use glam::DVec3;

use super::Domain;

/// The domain of a relative index of refraction: far beyond any known material, and its square is harmless.
pub(super) const ETA: Domain = Domain::Closed(1e-3, 1e3);

/// The index of the far side over that of the near side, for a direction on the near side, from that of the interior
/// (z < 0) over the exterior.
#[inline]
pub(crate) fn relative(eta: f64, w: DVec3) -> f64 {
    if w.z < 0.0 { 1.0 / eta } else { eta }
}
