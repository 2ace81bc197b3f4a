//! Pairs of points of two polygons, weighted by the kernel: lines along which to ask what is in between.
//!
//! With w = cos θ cos θ' / (π r²), and V = 1 where the points see each other, else 0,
//!
//! A F ≈ Σ w V / Σ w · (A F with nothing in between)
//!
//! V is not independent of the kernel: near patches exchange most where they are nearest, and that is what is hidden
//! first or last. A mean of V without weights is wrong there, however many lines are traced.
//! # References
//! - Roberts 2018, The unreasonable effectiveness of quasirandom sequences (the additive sequence of any dimension)

use glam::{DVec2, DVec3};

use super::exchange::{Front, cut, in_front};
use crate::render::radiosity::polygon::Polygon;

/// A line between two polygons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// A point of the first.
    pub from: DVec3,
    /// A point of the second.
    pub to: DVec3,
    /// Its share of the exchange, positive \[m²\].
    pub weight: f64,
}

/// Powers of the inverse of the root of x⁵ = x + 1.
const STEPS: [f64; 4] = [0.8566748838545029, 0.733891856627126, 0.6287067210378087, 0.5385972572236101];

/// Fills `links` with lines from `a` to `b`, of weights that add up to `exchange`.
///
/// The points are those of an additive sequence in four dimensions, shifted by `shift` (in [0, 1)⁴, the same for the
/// same lines): uniform in area on both polygons, or on their parts in front of each other if they cut each other's
/// planes. There are `count` of them at most, none if nothing is exchanged; pairs that do not face each other are left
/// out. As a function of a uniform shift, Σ w V / Σ w has a bias of the order of 1/count.
pub fn links(a: &Polygon, b: &Polygon, exchange: f64, count: usize, shift: [f64; 4], links: &mut Vec<Link>) {
    links.clear();
    match in_front(a, b) {
        Front::Nothing => {}
        Front::Everything => fill(a, b, exchange, count, shift, links),
        Front::Part => {
            if let Some((a, b)) = cut(a, b) {
                fill(&a, &b, exchange, count, shift, links);
            }
        }
    }
}

fn fill(a: &Polygon, b: &Polygon, exchange: f64, count: usize, shift: [f64; 4], links: &mut Vec<Link>) {
    let mut sum = 0.0;
    for i in 0..count {
        let u = |axis: usize| (shift[axis] + i as f64 * STEPS[axis]).fract();
        let (from, to) = (a.sample(DVec2::new(u(0), u(1))), b.sample(DVec2::new(u(2), u(3))));
        let line = to - from;
        let r2 = line.length_squared();
        let (cos_from, cos_to) = (line.dot(a.normal()), -line.dot(b.normal()));
        let weight = cos_from * cos_to / (r2 * r2);
        if cos_from > 0.0 && cos_to > 0.0 && weight.is_finite() {
            sum += weight;
            links.push(Link { from, to, weight });
        }
    }
    for link in links {
        link.weight *= exchange / sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sum::Moments;
    use crate::render::radiosity::form;

    fn rectangle(corner: DVec3, x: DVec3, y: DVec3) -> Polygon {
        Polygon::new(vec![corner, corner + x, corner + x + y, corner + y]).unwrap()
    }

    fn floor() -> Polygon {
        rectangle(DVec3::ZERO, DVec3::X, DVec3::Y)
    }

    /// A shift, different for each `i`, and as good as random: the fractions of multiples of irrational numbers.
    fn shift(i: i32) -> [f64; 4] {
        [2.0_f64, 3.0, 5.0, 7.0].map(|prime| (f64::from(i) * prime.sqrt()).fract())
    }

    /// Mean and spread of the visible exchange between unit squares at distance 1 with a quarter-size blocker in the
    /// middle of the gap's corner, with `count` lines; weighted by the kernel or not.
    fn obstructed(count: usize, weighted: bool) -> Moments {
        let (a, b) = (floor(), rectangle(DVec3::Z, DVec3::Y, DVec3::X));
        let exchange = form::exchange(&a, &b);
        let (mut stats, mut lines) = (Moments::default(), Vec::new());
        for i in 0..2000 {
            links(&a, &b, exchange, count, shift(i), &mut lines);
            let weight = |link: &Link| if weighted { link.weight } else { exchange / lines.len() as f64 };
            let middle = |link: &Link| 0.5 * (link.from + link.to);
            let seen = lines.iter().filter(|link| middle(link).x.max(middle(link).y) > 0.5);
            stats.add(seen.map(weight).sum());
        }
        stats
    }

    #[test]
    fn a_blocker_hides_what_it_must() {
        // Exact by symmetry: ¾ of what is exchanged without it.
        let exact = 0.75 * 0.199824895698387;
        let sixteen = obstructed(16, true);
        // The ratio's bias falls with the number of lines; 16 leave less than 0.2 % of it.
        assert!((sixteen.mean() / exact - 1.0).abs() < 4e-3, "{}", sixteen.mean() / exact);
        // Independent lines have a variance of V (1 − V)/n at least, here 3/16 F²/16.
        let independent = (0.1875_f64 / 16.0).sqrt() * 0.2;
        assert!(sixteen.variance().sqrt() < 0.7 * independent, "{}", sixteen.variance().sqrt() / independent);
    }

    #[test]
    fn visibility_without_the_kernel_is_biased() {
        // Two walls of a corner, and a fin that hides the half of each that is nearer to the edge from the other's.
        let (a, b) = (floor(), rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z));
        let exchange = form::exchange(&a, &b);
        let near = |size: f64| {
            form::exchange(
                &rectangle(DVec3::ZERO, DVec3::X * size, DVec3::Y),
                &rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z * size),
            )
        };
        let share = 1.0 - near(0.5) / exchange;
        let (mut weighted, mut plain, mut lines) = (Moments::default(), Moments::default(), Vec::new());
        for i in 0..2000 {
            links(&a, &b, 1.0, 256, shift(i), &mut lines);
            let seen = |link: &&Link| link.from.x > 0.5 || link.to.z > 0.5;
            weighted.add(lines.iter().filter(seen).map(|link| link.weight).sum());
            plain.add(lines.iter().filter(seen).count() as f64 / lines.len() as f64);
        }
        // The kernel is not square integrable at the common edge: 256 lines leave a bias of 0.023 to their ratio.
        assert!((weighted.mean() - share).abs() < 0.04, "{} {share}", weighted.mean());
        assert!((plain.mean() - 0.75).abs() < 0.01 && share < 0.6, "{} {share}", plain.mean());
    }

    #[test]
    fn lines_face_and_their_weights_add_up() {
        let pentagon = (0..5).map(|i| f64::from(i) * 1.2566).map(|t| DVec3::new(0.2, t.cos(), t.sin()));
        let through = Polygon::new(pentagon.collect()).unwrap();
        for (b, expected) in [(through.clone(), true), (through.flipped(), true), (floor(), false)] {
            let mut lines = vec![Link { from: DVec3::ZERO, to: DVec3::ZERO, weight: 1.0 }];
            let exchange = form::exchange(&floor(), &b);
            links(&floor(), &b, exchange, 8, [0.1, 0.7, 0.2, 0.4], &mut lines);
            assert_eq!(!lines.is_empty(), expected);
            let sum: f64 = lines.iter().map(|link| link.weight).sum();
            assert!((sum - exchange).abs() <= 1e-15);
            assert!(lines.iter().all(|link| link.to.z > 0.0 && link.weight > 0.0), "cut at the floor");
            let mut again = Vec::new();
            links(&floor(), &b, exchange, 8, [0.1, 0.7, 0.2, 0.4], &mut again);
            assert_eq!(lines, again);
        }
    }
}
