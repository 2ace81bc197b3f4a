//! The sphere as two hemispheres, each seen so that the fixed and the free direction lie above the horizon.
//!
//! Reflection and transmission then are integrated alike, by charts of the hemisphere above; only where a lobe is looked
//! for differs: about the mirror direction, or about the refracted one mirrored in the tangent plane.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::bsdf::{Bsdf, Lobes, relative};
use crate::math::chart::Chart;
use crate::math::sphere::{direction_mu, flip, mirror, refract};
use crate::sampling::stream::{stream, uniform, uniforms};

/// The height above the horizon at which transmission is looked for where nothing is refracted.
const GRAZING: f64 = 0.02;

/// A hemisphere of free directions about a fixed one, both upright.
#[derive(Clone, Copy, Debug)]
pub struct Half {
    fixed: DVec3,
    /// Where a lobe is expected.
    centre: DVec3,
    fixed_below: bool,
    free_below: bool,
    /// The index of the far side over the near one, where facets refract.
    facets: Option<f64>,
}

impl Half {
    /// The free directions on the side of `w`; for a `w` above the horizon they are what they seem.
    pub fn reflected(w: DVec3) -> Self {
        let below = w.z < 0.0;
        let fixed = upright(w, below);
        Self { fixed, centre: mirror(fixed), fixed_below: below, free_below: below, facets: None }
    }

    /// The free directions on the other side of an interface whose interior has the index `eta` over the exterior.
    pub fn transmitted(w: DVec3, eta: f64) -> Self {
        let below = w.z < 0.0;
        let fixed = upright(w, below);
        let refracted = refract(fixed, DVec3::Z, relative(eta, w)).map(flip).filter(|v| v.z > 0.0);
        let grazing = direction_mu(GRAZING, (-w.y).atan2(-w.x));
        Self { fixed, centre: refracted.unwrap_or(grazing), fixed_below: below, free_below: !below, facets: None }
    }

    /// The hemispheres in which `bsdf` can be lit for the fixed direction `w`: none in the tangent plane.
    pub fn all(bsdf: &dyn Bsdf, w: DVec3) -> Vec<Self> {
        if w.z == 0.0 {
            return Vec::new();
        }
        let transmits = bsdf.lobes().contains(Lobes::TRANSMIT);
        let facets = bsdf.normals().map(|_| relative(bsdf.eta(), w)).filter(|&eta| eta != 1.0);
        let transmitted = transmits.then(|| Self { facets, ..Self::transmitted(w, bsdf.eta()) });
        std::iter::once(Self::reflected(w)).chain(transmitted).collect()
    }

    /// The fixed direction, upright.
    pub fn fixed(&self) -> DVec3 {
        self.fixed
    }

    /// The upright direction about which a lobe is expected.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// The free direction that is seen as `v`.
    pub fn free(&self, v: DVec3) -> DVec3 {
        upright(v, self.free_below)
    }

    /// The free direction `w` as it is seen; None on the other side and in the tangent plane.
    pub fn seen(&self, w: DVec3) -> Option<DVec3> {
        Some(upright(w, self.free_below)).filter(|v| v.z > 0.0)
    }

    /// Three charts that between them resolve lobes of any width, the best first, of an integrand that is `lit` in the
    /// directions, as they are seen, where this holds.
    pub(crate) fn charts(&self, lit: impl Fn(DVec3) -> bool) -> [Chart; 3] {
        let upright = Chart::upright(self.fixed);
        let about = Chart::about(self.centre, self.fixed);
        if self.free_below == self.fixed_below {
            return [Chart::half(self.fixed), about, upright];
        }
        let refracted = self.facets.map(|eta| Chart::refracted(self.fixed, eta));
        match refracted.filter(|chart| !grid(&upright).any(|v| lit(v) && chart.coordinates(v).x > 1.0)) {
            Some(chart) => [chart, about, upright],
            // The second must not have its nodes where the first has.
            None => [about, about.recut(), upright],
        }
    }
}

/// Directions all over the hemisphere of a chart.
fn grid(chart: &Chart) -> impl Iterator<Item = DVec3> {
    const SIDE: u32 = 24;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIDE);
    (0..SIDE * SIDE).map(move |i| chart.row(TAU * at(i / SIDE)).at(at(i % SIDE)).0)
}

fn upright(w: DVec3, below: bool) -> DVec3 {
    if below { flip(w) } else { w }
}

/// Whether `bsdf` is lit from below too: it says that it transmits, or its sampler reflects there.
pub fn is_two_faced(bsdf: &dyn Bsdf) -> bool {
    let mut rng = stream(0, 2, 0);
    bsdf.lobes().contains(Lobes::TRANSMIT)
        || (0..16).any(|_| {
            let below = direction_mu(-1.0 + 0.98 * uniform(&mut rng), 6.0 * uniform(&mut rng));
            bsdf.sample(below, uniforms(&mut rng)).is_some_and(|s| s.wi.z < 0.0)
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Dielectric, Lambert, TwoSided};
    use crate::math::sphere::direction;

    #[test]
    fn directions_come_back_and_belong_to_one_half() {
        let glass = Dielectric::new(1.5).unwrap();
        for wo in [direction(0.4, 1.0), direction(2.0, 1.0)] {
            let halves = Half::all(&glass, wo);
            for wi in [direction(0.7, 0.2), direction(3.0, 0.2)] {
                let seen: Vec<DVec3> = halves.iter().filter_map(|half| half.seen(wi)).collect();
                assert!(seen.len() == 1 && seen[0].z > 0.0);
                let free: Vec<DVec3> = halves.iter().map(|half| half.free(seen[0])).collect();
                assert!(free.contains(&wi) && free[0] == flip(free[1]));
            }
            assert!(halves.iter().all(|half| half.fixed().z > 0.0 && half.centre().z > 0.0));
        }
    }

    #[test]
    fn one_side_two_sides() {
        let lambert = Lambert::new(0.5).unwrap();
        assert!(!is_two_faced(&lambert) && is_two_faced(&TwoSided::new(lambert)));
        assert!(is_two_faced(&Dielectric::new(1.5).unwrap()));
        assert_eq!(Half::all(&lambert, DVec3::Z).len(), 1);
    }
}
