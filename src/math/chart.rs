//! Polar coordinates on the hemisphere that follow a lobe and end exactly at the horizon.
//!
//! A chart maps (t, φ) in [0, 1] × [0, 2π) onto the directions above the horizon. Around its pole, the angle grows as
//!
//! θ(t) = θmax(φ) sinh(k t) / sinh(k),
//!
//! linearly at first and then exponentially, so that features of every size down to θmax k / sinh k are equally easy
//! to see. θmax(φ) is where the ray meets the horizon, in closed form: with a pole at polar angle θp, the height of
//! the direction at angle θ along azimuth φ is A cos(θ − δ), δ = atan2(sinθp cosφ, cosθp), A² = cos²θp + sin²θp cos²φ.
//! The horizon is therefore an edge of the domain and costs an integrator nothing.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};

use super::sphere::{basis, flip, half_vector};

/// Zoom of the charts about a lobe: resolves angles from θmax down to about 2·10⁻⁵ θmax without any subdivision.
const ZOOM: f64 = 14.0;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// The angle is between the pole and the direction itself.
    Direction,
    /// The angle is between the normal and the half vector of the direction and `wo`.
    Half,
    /// The angle is between the normal and a microfacet normal visible from `wo`.
    VisibleNormal,
    /// The angle is between the normal and the microfacet that refracts `wo` into the direction, mirrored upwards.
    Refracted,
}

/// A coordinate system on the hemisphere above the surface.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    kind: Kind,
    /// φ = 0, φ = π/2 and the pole itself.
    axes: [DVec3; 3],
    wo: DVec3,
    zoom: f64,
    sinh_zoom: f64,
    /// Equal parts into which φ is cut at first.
    sectors: u32,
    /// Index of the far side over the near side, of the chart of refracting normals.
    eta: f64,
}

/// A ray of constant φ in a chart.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    kind: Kind,
    pole: DVec3,
    side: DVec3,
    wo: DVec3,
    /// A of the module's formula: the height of the highest direction on the great circle of this ray.
    height: f64,
    limit: f64,
    zoom: f64,
    sinh_zoom: f64,
    eta: f64,
}

/// The azimuth of `w` as a unit vector in the plane; +x where it has none.
fn heading(w: DVec3) -> DVec3 {
    DVec3::new(w.x, w.y, 0.0).normalize_or(DVec3::X)
}

impl Chart {
    fn zoomed(self) -> Self {
        Self { zoom: ZOOM, sinh_zoom: ZOOM.sinh(), ..self }
    }

    /// Angles from the normal, evenly spaced; φ = 0 along the azimuth of `wo`. Fits diffuse reflection.
    pub fn upright(wo: DVec3) -> Self {
        let x = heading(wo);
        Self {
            kind: Kind::Direction,
            axes: [x, DVec3::Z.cross(x), DVec3::Z],
            wo,
            zoom: 0.0,
            sinh_zoom: 0.0,
            sectors: 4,
            eta: 1.0,
        }
    }

    /// Angles from `pole`, zoomed towards it; φ = 0 ascends. Fits lobes about a direction, such as Phong's.
    pub fn about(pole: DVec3, wo: DVec3) -> Self {
        if pole.x == 0.0 && pole.y == 0.0 {
            return Self::upright(wo).zoomed();
        }
        let (s, t) = basis(pole);
        Self { kind: Kind::Direction, axes: [t, s, pole], ..Self::upright(wo) }.zoomed()
    }

    /// The same chart with its nodes elsewhere: zoomed less, and cut into other sectors. What one of the two overlooks, the
    /// other need not.
    pub fn recut(self) -> Self {
        let zoom = 0.8 * self.zoom;
        Self { zoom, sinh_zoom: zoom.sinh(), sectors: self.sectors + 1, ..self }
    }

    /// Angles of the half vector from the normal, zoomed; φ = 0 leans towards `wo`. Fits microfacet models.
    pub fn half(wo: DVec3) -> Self {
        Self { kind: Kind::Half, ..Self::upright(wo) }.zoomed()
    }

    /// Microfacet normals m with m.z > 0 that `wo` sees from the front (wo·m > 0): the domain of visible normals. The
    /// direction at (t, φ) is m itself.
    pub fn visible_normals(wo: DVec3) -> Self {
        Self { kind: Kind::VisibleNormal, ..Self::upright(wo) }.zoomed()
    }

    /// Microfacet normals that refract `wo`, for the index `eta` ≠ 1 of the far side over the near side; directions are
    /// seen mirrored upwards. Only what facets facing `wo` can refract is covered: fits rough glass and nothing else.
    pub fn refracted(wo: DVec3, eta: f64) -> Self {
        Self { kind: Kind::Refracted, eta, ..Self::upright(wo) }.zoomed()
    }

    /// Polar angle of the chart's pole (of `wo`, for the charts of half vectors and normals) as (sin, cos).
    fn tilt(&self) -> (f64, f64) {
        let w = if self.kind == Kind::Direction { self.axes[2] } else { self.wo };
        (w.x.hypot(w.y), w.z)
    }

    /// For the azimuth whose cosine is `cos_phi`: the height A of the highest direction on its great circle, and θmax.
    fn horizon(&self, cos_phi: f64) -> (f64, f64) {
        let (sin_tilt, cos_tilt) = self.tilt();
        let rise = sin_tilt * cos_phi;
        let delta = rise.atan2(cos_tilt);
        let height = (rise * rise + cos_tilt * cos_tilt).sqrt();
        let limit = match self.kind {
            Kind::Direction => FRAC_PI_2 + delta,
            // wi.z = A cos(2θ − δ), since wi lies at twice the angle of the half vector, seen from −wo mirrored.
            Kind::Half => 0.5 * (FRAC_PI_2 + delta),
            // wo·m = A cos(θ − δ), and m.z > 0.
            Kind::VisibleNormal => FRAC_PI_2 + delta.min(0.0),
            // Besides, wo·m is at least the cosine of the critical angle.
            Kind::Refracted => {
                let critical = ((1.0 - self.eta) * (1.0 + self.eta)).max(0.0).sqrt();
                (FRAC_PI_2 + delta.min(0.0)).min(delta + (critical / height).min(1.0).acos()).max(0.0)
            }
        };
        (height, limit)
    }

    /// The ray at azimuth `phi`.
    pub fn row(&self, phi: f64) -> Row {
        let (sin_phi, cos_phi) = phi.sin_cos();
        let (height, limit) = self.horizon(cos_phi);
        Row {
            kind: self.kind,
            pole: self.axes[2],
            side: cos_phi * self.axes[0] + sin_phi * self.axes[1],
            wo: self.wo,
            height,
            limit,
            zoom: self.zoom,
            sinh_zoom: self.sinh_zoom,
            eta: self.eta,
        }
    }

    /// The coordinates (t, φ) of the direction `w`; t > 1 beyond the horizon.
    pub fn coordinates(&self, w: DVec3) -> DVec2 {
        let v = match self.kind {
            Kind::Half => half_vector(self.wo, w),
            // Along the normal, wo + η wi has the sign of 1 − η.
            Kind::Refracted => (1.0 - self.eta).signum() * (self.wo + self.eta * flip(w)),
            Kind::Direction | Kind::VisibleNormal => w,
        };
        let (x, y, z) = (v.dot(self.axes[0]), v.dot(self.axes[1]), v.dot(self.axes[2]));
        let r = (x * x + y * y).sqrt();
        let phi = y.atan2(x);
        let phi = if phi < 0.0 { phi + TAU } else { phi };
        let (_, limit) = self.horizon(if r > 0.0 { x / r } else { 1.0 });
        // Where nothing is refracted at this azimuth, everything lies beyond the edge.
        let part = if limit > 0.0 { r.atan2(z) / limit } else { f64::INFINITY };
        let t = if self.zoom == 0.0 { part } else { (self.sinh_zoom * part).asinh() / self.zoom };
        DVec2::new(t, phi)
    }

    /// Where to cut t and φ before anything is known: at the kinks that reflection models have in these coordinates.
    ///
    /// Diffuse models break at θi = θo and at right angles to the plane of incidence; charts about a lobe are cut so
    /// that each panel spans a few factors e of angle. Near grazing, the angle from the fixed direction to the horizon
    /// sets a scale of its own: on it lobes are cut off and squeezed into the plane of incidence, and next to an edge of
    /// a panel, closer than its first node, that would stay unseen.
    pub fn breaks(&self) -> (Vec<f64>, Vec<f64>) {
        let left = self.wo.z.atan2(self.wo.x.hypot(self.wo.y)) / FRAC_PI_2;
        let grazing = left < 0.06;
        let mut azimuths: Vec<f64> = (0..=self.sectors).map(|i| TAU * f64::from(i) / f64::from(self.sectors)).collect();
        let radial = if self.zoom > 0.0 {
            if grazing {
                // The horizon turns where the ray runs along it; lobes about a direction lie in the plane of incidence.
                let critical =
                    if self.kind == Kind::Direction { [0.0, 0.5 * TAU, TAU] } else { [0.25 * TAU, 0.75 * TAU, TAU] };
                let sides = critical.into_iter().flat_map(|phi| [phi - 8.0 * left, phi + 8.0 * left]);
                azimuths.extend(sides.filter(|phi| (0.0..TAU).contains(phi)));
                azimuths.sort_by(f64::total_cmp);
            }
            vec![0.0, 0.4, 0.7, 1.0]
        } else {
            let cuts = [1.0 - 16.0 * left, 1.0 - 4.0 * left, 1.0 - left, 1.0 - 0.25 * left];
            // Layers along the horizon may have a scale that is not the view's: a last thin strip is for them.
            let near_horizon = if grazing { cuts.to_vec() } else { vec![1.0 - left, 0.98] };
            let inner = near_horizon.into_iter().filter(|t| (1e-3..1.0 - 1e-12).contains(t));
            std::iter::once(0.0).chain(inner).chain(std::iter::once(1.0)).collect()
        };
        (radial, azimuths)
    }
}

impl Row {
    /// The direction at `t` in (0, 1), and dω / (dt dφ) \[sr\].
    pub fn at(&self, t: f64) -> (DVec3, f64) {
        let (part, slope) = if self.zoom == 0.0 {
            (t, 1.0)
        } else {
            let e = (self.zoom * t).exp();
            let (sinh, cosh) = if self.zoom * t < 1.0 {
                ((self.zoom * t).sinh(), (self.zoom * t).cosh())
            } else {
                (0.5 * (e - 1.0 / e), 0.5 * (e + 1.0 / e))
            };
            (sinh / self.sinh_zoom, self.zoom * cosh / self.sinh_zoom)
        };
        let theta = self.limit * part;
        let (sin, cos) = theta.sin_cos();
        let v = cos * self.pole + sin * self.side;
        let area = sin * self.limit * slope;
        // The height above the horizon from the angle left to it: full relative precision next to the horizon.
        let left = self.limit * (1.0 - part);
        match self.kind {
            Kind::VisibleNormal => (v, area),
            Kind::Direction => (DVec3::new(v.x, v.y, self.height * left.sin()), area),
            Kind::Refracted => {
                let c = self.wo.dot(v);
                let root = ((self.eta - 1.0) * (self.eta + 1.0) + c * c).max(0.0).sqrt();
                let along = c - root;
                let wi = (along * v - self.wo) / self.eta;
                // dwi/dm = |wo + η wi|² / (η² cosθi). Past an edge there is nothing.
                if c > 0.0 && root > 0.0 && wi.z < 0.0 {
                    (flip(wi), area * along * along / (self.eta * root))
                } else {
                    (DVec3::Z, 0.0)
                }
            }
            Kind::Half => {
                let cos_d = self.wo.dot(v);
                let wi = 2.0 * cos_d * v - self.wo;
                (DVec3::new(wi.x, wi.y, self.height * (2.0 * left).sin()), 4.0 * cos_d * area)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quadrature::adaptive;
    use crate::math::sphere::{direction, mirror};
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn charts(wo: DVec3) -> [Chart; 5] {
        let about = Chart::about(mirror(wo), wo);
        [Chart::upright(wo), about, about.recut(), Chart::about(wo, wo), Chart::half(wo)]
    }

    proptest! {
        #[test]
        fn coordinates_invert_the_map(theta in 0.0..1.57_f64, phi in -3.0..3.0_f64, t in 0.01..0.99_f64, azimuth in 0.01..6.2_f64) {
            let wo = direction(theta, phi);
            for chart in charts(wo) {
                let (w, jacobian) = chart.row(azimuth).at(t);
                prop_assert!(w.z > 0.0 && jacobian > 0.0 && (w.length() - 1.0).abs() < 1e-14);
                // The direction comes back wherever it lies; of a half vector, as well as the sum it is made of is known.
                let lever = if chart.kind == Kind::Half { (wo + w).length().min(1.0) } else { 1.0 };
                let back = chart.coordinates(w);
                let (again, _) = chart.row(back.y).at(back.x);
                prop_assert!((again - w).length() < 16.0 * f64::EPSILON / lever, "{chart:?}: {w} came back as {again}");
            }
        }
    }

    #[test]
    fn every_chart_covers_the_hemisphere_once() {
        for theta in [0.0, 0.4, 1.2, 1.55] {
            for chart in charts(direction(theta, 0.3)) {
                // ∫ cos² dω = 2π/3; a wrong edge or Jacobian of any chart changes it.
                let (radial, quarters) = chart.breaks();
                let inner = |phi: f64| {
                    let row = chart.row(phi);
                    adaptive(
                        |t| {
                            let (w, j) = row.at(t);
                            [w.z * w.z * j]
                        },
                        &radial,
                        1e-12,
                        60,
                    )
                    .value
                };
                let total = adaptive(inner, &quarters, 1e-11, 100).value[0];
                assert!((total - 2.0 * PI / 3.0).abs() < 1e-10, "{theta} {chart:?}: {total}");
            }
        }
    }

    #[test]
    fn refracting_normals_cover_what_they_can_refract() {
        for (theta, eta) in [(0.0, 1.5), (0.9, 1.5), (1.4, 1.33), (0.3, 1.0 / 1.5), (0.6, 0.9)] {
            let wo = direction(theta, 0.3);
            let chart = Chart::refracted(wo, eta);
            let mut covered = 0.0;
            let sphere = Chart::upright(wo);
            for i in 0..400 {
                let row = sphere.row(TAU * (f64::from(i) + 0.5) / 400.0);
                for k in 0..400 {
                    let (w, area) = row.at((f64::from(k) + 0.5) / 400.0);
                    let m = (1.0 - eta).signum() * (wo + eta * flip(w));
                    if m.z > 0.0 && wo.dot(m) > 0.0 && flip(w).dot(m) < 0.0 {
                        covered += area * TAU / 160_000.0;
                        let p = chart.coordinates(w);
                        let (back, _) = chart.row(p.y).at(p.x);
                        assert!((back - w).length() < 1e-6, "{theta} {eta}: {w} came back as {back}");
                    }
                }
            }
            let (radial, sectors) = chart.breaks();
            let inner = |phi: f64| {
                let row = chart.row(phi);
                adaptive(|t| [row.at(t).1], &radial, 1e-7, 100).value
            };
            let total = adaptive(inner, &sectors, 1e-6, 100).value[0];
            // The grid of 160 000 cells is cut by the edge.
            assert!((total - covered).abs() < 5e-3, "{theta} {eta}: {total} {covered}");
        }
    }

    #[test]
    fn visible_normals_end_where_they_turn_away() {
        let wo = direction(1.2, 0.5);
        let chart = Chart::visible_normals(wo);
        for phi in [0.0, 1.0, 2.0, 3.0] {
            let (edge, _) = chart.row(phi).at(1.0 - 1e-12);
            assert!(edge.z.min(edge.dot(wo)).abs() < 1e-9, "{phi}: {edge}");
        }
    }
}
