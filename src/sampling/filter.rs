//! Reconstruction filters by filter importance sampling.
//!
//! A pixel's value is ∫ f(x) L(x) dx / ∫ f(x) dx over offsets x from its centre. An offset is drawn in proportion to
//! |f| and its sample gets the weight sign(f) ∫|f| / ∫f, so that each sample belongs to one pixel, samples of one
//! pixel are independent, and the variance on the film is honest. Positive filters have weight 1 exactly.
//!
//! Every filter is separable, f(x) f(y). Box and tent are exact; the others are tables of [`CELLS`] cells from the
//! centre to the radius, linear within each: within 1e-5 of the named function's peak.
//!
//! | name | f(x) for x ≥ 0 | radius |
//! |---|---|---|
//! | `box` | 1 | 1/2 |
//! | `tent` | 1 − x/r | r = 1 |
//! | `gaussian` | exp(−x²/2σ²) − exp(−r²/2σ²) | r = 4σ, σ = 1/2 |
//! | `mitchell` | Mitchell & Netravali's cubic, B = C = 1/3 | 2 |
//! | `catmullrom` | the same with B = 0, C = 1/2 | 2 |
//! | `lanczos` | sinc(x) sinc(x/r) | r = 3 |
//!
//! Names and defaults are those of Mitsuba 3.
//! # References
//! - Ernst, Stamminger & Greiner 2006, Filter importance sampling, IEEE Symposium on Interactive Ray Tracing
//! - Mitchell & Netravali 1988, Reconstruction filters in computer graphics, SIGGRAPH, eq. 8

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::DVec2;

use crate::sampling::tabulated::PiecewiseLinear;

/// Cells of a table from the centre to the radius.
pub const CELLS: usize = 1024;

/// What is wrong with the name of a filter or its parameters.
#[derive(Debug, thiserror::Error, PartialEq)]
#[error("{}; known are {KNOWN}", self.problem())]
pub struct FilterError {
    typed: String,
    reason: String,
}

impl FilterError {
    /// What is wrong with which filter.
    pub fn problem(&self) -> String {
        format!("filter {}: {}", self.typed, self.reason)
    }
}

/// The filters with their defaults, as they are spelled.
pub const KNOWN: &str =
    "box, tent:radius=1, gaussian:stddev=0.5,radius=2, mitchell:b=1/3,c=1/3, catmullrom, lanczos:lobes=3";

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Box,
    Tent { radius: f64 },
    Gaussian { stddev: f64, radius: f64 },
    Mitchell { b: f64, c: f64 },
    CatmullRom,
    Lanczos { lobes: f64 },
}

/// A reconstruction filter. It is spelled `name` or `name:key=value,…`, for [`str::parse`] and [`fmt::Display`].
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    kind: Kind,
    table: Option<Arc<Table>>,
}

impl Filter {
    /// Each sample counts alike within its pixel, nothing outside.
    pub const BOX: Self = Self { kind: Kind::Box, table: None };

    /// A tent that falls to 0 at one pixel.
    pub const TENT: Self = Self { kind: Kind::Tent { radius: 1.0 }, table: None };

    /// A tent that falls to 0 at `radius` pixels, in (0, 16].
    pub fn tent(radius: f64) -> Result<Self, FilterError> {
        Self::new(Kind::Tent { radius })
    }

    /// A Gaussian of standard deviation `stddev`, lowered to reach 0 at `radius`, both in pixels; radius in (0, 16],
    /// stddev from radius/16 to 16 radius.
    pub fn gaussian(stddev: f64, radius: f64) -> Result<Self, FilterError> {
        Self::new(Kind::Gaussian { stddev, radius })
    }

    /// Mitchell and Netravali's cubic with `b` and `c` in [0, 1].
    pub fn mitchell(b: f64, c: f64) -> Result<Self, FilterError> {
        Self::new(Kind::Mitchell { b, c })
    }

    /// The sinc windowed by its own main lobe at `lobes` pixels, a whole number from 1 to 16.
    pub fn lanczos(lobes: u32) -> Result<Self, FilterError> {
        Self::new(Kind::Lanczos { lobes: f64::from(lobes) })
    }

    fn new(kind: Kind) -> Result<Self, FilterError> {
        let ok = |good: bool, reason: &str| if good { Ok(()) } else { Err(reason.to_string()) };
        let radius_allowed = "the radius must be in (0, 16]";
        let size = |radius: f64| radius > 0.0 && radius <= 16.0;
        match kind {
            Kind::Box | Kind::CatmullRom => Ok(()),
            Kind::Tent { radius } => ok(size(radius), radius_allowed),
            Kind::Gaussian { stddev, radius } => ok(size(radius), radius_allowed).and_then(|()| {
                // Narrower, and the table would not follow it; wider, and lowering it would leave no digits.
                ok((radius / 16.0..=radius * 16.0).contains(&stddev), "stddev must be in [radius/16, 16 radius]")
            }),
            Kind::Mitchell { b, c } => {
                let good = |x: f64| (0.0..=1.0).contains(&x);
                ok(good(b) && good(c), "b and c must be in [0, 1]")
            }
            Kind::Lanczos { lobes } => ok(size(lobes) && lobes.fract() == 0.0, "lobes must be a whole number to 16"),
        }
        .map_err(|reason| FilterError { typed: spelled(&kind), reason })?;
        let table = match kind {
            Kind::Box | Kind::Tent { .. } => None,
            _ => Some(Arc::new(
                Table::new(radius(&kind), |x| value(&kind, x))
                    .ok_or_else(|| FilterError { typed: spelled(&kind), reason: "it has no positive mass".into() })?,
            )),
        };
        Ok(Self { kind, table })
    }

    /// The distance from the centre along an axis, in pixels, beyond which the filter is 0.
    pub fn radius(&self) -> f64 {
        radius(&self.kind)
    }

    /// The filter at an offset from the pixel's centre, 1 at the centre of box and tent; not normalised.
    pub fn eval(&self, offset: DVec2) -> f64 {
        value(&self.kind, offset.x) * value(&self.kind, offset.y)
    }

    /// An offset from the pixel's centre in pixels, in proportion to |f|, and the weight of its sample.
    ///
    /// `u` in [0, 1)². The mean of the weight over `u` is 1.
    pub fn sample(&self, u: DVec2) -> (DVec2, f64) {
        match (&self.kind, &self.table) {
            (Kind::Tent { radius }, _) => (*radius * DVec2::new(tent(u.x), tent(u.y)), 1.0),
            (_, Some(table)) => {
                let (x, weight_x) = table.sample(u.x);
                let (y, weight_y) = table.sample(u.y);
                (DVec2::new(x, y), weight_x * weight_y)
            }
            (_, None) => (u - 0.5, 1.0),
        }
    }
}

/// From uniform to the density 1 − |x| on (−1, 1).
fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

fn radius(kind: &Kind) -> f64 {
    match *kind {
        Kind::Box => 0.5,
        Kind::Tent { radius } | Kind::Gaussian { radius, .. } => radius,
        Kind::Mitchell { .. } | Kind::CatmullRom => 2.0,
        Kind::Lanczos { lobes } => lobes,
    }
}

fn value(kind: &Kind, x: f64) -> f64 {
    let x = x.abs();
    if x >= radius(kind) {
        // The half-open box: its left edge is in.
        return if *kind == Kind::Box && x == 0.5 { 1.0 } else { 0.0 };
    }
    match *kind {
        Kind::Box => 1.0,
        Kind::Tent { radius } => 1.0 - x / radius,
        Kind::Gaussian { stddev, radius } => {
            let bell = |x: f64| (-0.5 * (x / stddev).powi(2)).exp();
            bell(x) - bell(radius)
        }
        Kind::Mitchell { b, c } => cubic(b, c, x),
        Kind::CatmullRom => cubic(0.0, 0.5, x),
        Kind::Lanczos { lobes } => sinc(x) * sinc(x / lobes),
    }
}

/// Mitchell & Netravali's piecewise cubic.
fn cubic(b: f64, c: f64, x: f64) -> f64 {
    let inner = [6.0 - 2.0 * b, 0.0, -18.0 + 12.0 * b + 6.0 * c, 12.0 - 9.0 * b - 6.0 * c];
    let outer = [8.0 * b + 24.0 * c, -12.0 * b - 48.0 * c, 6.0 * b + 30.0 * c, -b - 6.0 * c];
    let polynomial = if x < 1.0 { inner } else { outer };
    polynomial.iter().rev().fold(0.0, |sum, term| sum * x + term) / 6.0
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}

/// |f| from the centre to the radius, with its sign in each cell.
#[derive(Debug, PartialEq)]
struct Table {
    magnitude: PiecewiseLinear,
    step: f64,
    negative: Vec<bool>,
    /// ∫|f| / ∫f.
    weight: f64,
}

impl Table {
    /// None where ∫f is not positive.
    fn new(radius: f64, f: impl Fn(f64) -> f64) -> Option<Self> {
        let step = radius / CELLS as f64;
        let magnitude: Vec<f64> = (0..=CELLS).map(|node| f(node as f64 * step).abs()).collect();
        let magnitude = PiecewiseLinear::new(&magnitude, radius)?;
        let negative: Vec<bool> = (0..CELLS).map(|cell| f((cell as f64 + 0.5) * step) < 0.0).collect();
        // From the table itself, so that the mean weight is 1 whatever the table is worth.
        let below = |node: usize| magnitude.sample_inv(node as f64 * step);
        let lost: f64 = (0..CELLS).filter(|&cell| negative[cell]).map(|cell| below(cell + 1) - below(cell)).sum();
        let weight = 1.0 / (1.0 - 2.0 * lost);
        (lost < 0.5).then_some(Self { magnitude, step, negative, weight })
    }

    fn sample(&self, u: f64) -> (f64, f64) {
        // The first half of u is the left side: the order along the axis is that of u, so stratified u stay apart.
        let (side, u) = if u < 0.5 { (-1.0, 1.0 - 2.0 * u) } else { (1.0, 2.0 * u - 1.0) };
        let x = self.magnitude.sample(u.min(1.0 - f64::EPSILON / 2.0));
        let cell = ((x / self.step) as usize).min(CELLS - 1);
        (side * x, if self.negative[cell] { -self.weight } else { self.weight })
    }
}

fn spelled(kind: &Kind) -> String {
    match kind {
        Kind::Box => "box".into(),
        Kind::Tent { radius } => format!("tent:radius={radius}"),
        Kind::Gaussian { stddev, radius } => format!("gaussian:stddev={stddev},radius={radius}"),
        Kind::Mitchell { b, c } => format!("mitchell:b={b},c={c}"),
        Kind::CatmullRom => "catmullrom".into(),
        Kind::Lanczos { lobes } => format!("lanczos:lobes={lobes}"),
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&spelled(&self.kind))
    }
}

impl FromStr for Filter {
    type Err = FilterError;

    fn from_str(typed: &str) -> Result<Self, FilterError> {
        let wrong = |reason: String| FilterError { typed: typed.chars().take(80).collect(), reason };
        let (name, rest) = typed.split_once(':').unwrap_or((typed, ""));
        let mut given = Vec::new();
        for pair in rest.split(',').filter(|pair| !pair.trim().is_empty()) {
            let (key, value) = pair.split_once('=').ok_or_else(|| wrong(format!("{pair} is no key=value")))?;
            let value = fraction(value).ok_or_else(|| wrong(format!("{} is no number", value.trim())))?;
            given.push((key.trim(), value));
        }
        let mut take = |key: &str| given.iter().position(|(k, _)| *k == key).map(|at| given.swap_remove(at).1);
        let kind = match name.trim() {
            "box" => Kind::Box,
            "tent" => Kind::Tent { radius: take("radius").unwrap_or(1.0) },
            "gaussian" => {
                let stddev = take("stddev").unwrap_or(0.5);
                Kind::Gaussian { stddev, radius: take("radius").unwrap_or(4.0 * stddev) }
            }
            "mitchell" => {
                let third = 1.0 / 3.0;
                Kind::Mitchell { b: take("b").unwrap_or(third), c: take("c").unwrap_or(third) }
            }
            "catmullrom" => Kind::CatmullRom,
            "lanczos" => Kind::Lanczos { lobes: take("lobes").unwrap_or(3.0) },
            _ => return Err(wrong("there is no such filter".into())),
        };
        match given.first() {
            Some((key, _)) => Err(wrong(format!("it has no parameter {key}, or it is given twice"))),
            None => Self::new(kind),
        }
    }
}

/// A number, or one over another.
fn fraction(text: &str) -> Option<f64> {
    match text.split_once('/') {
        Some((above, below)) => Some(above.trim().parse::<f64>().ok()? / below.trim().parse::<f64>().ok()?),
        None => text.trim().parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn all() -> Vec<Filter> {
        ["box", "tent", "gaussian", "gaussian:stddev=0.3,radius=1", "mitchell", "catmullrom", "lanczos"]
            .map(|name| name.parse().unwrap())
            .into()
    }

    /// Midpoint sums over the uniform x: the weights' mean, and the k-th moment of the offset.
    fn moment(filter: &Filter, k: i32) -> f64 {
        let n = 1 << 16;
        let one = |i: i32| {
            let (offset, weight) = filter.sample(DVec2::new((f64::from(i) + 0.5) / f64::from(n), 0.6));
            // The weight along y at 0.6 is that of the positive main lobe.
            offset.x.powi(k) * weight / filter.sample(DVec2::new(0.6, 0.6)).1.sqrt()
        };
        (0..n).map(one).sum::<f64>() / f64::from(n)
    }

    /// ∫ xᵏ f dx / ∫ f dx by the midpoint rule.
    fn by_quadrature(filter: &Filter, k: i32) -> f64 {
        let (n, r) = (100_000, filter.radius());
        let x = |i: i32| r * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
        let sum = |k: i32| (0..n).map(|i| x(i).powi(k) * filter.eval(DVec2::new(x(i), 0.0))).sum::<f64>();
        sum(k) / sum(0)
    }

    #[test]
    fn weights_have_mean_one_and_offsets_the_moments_of_the_filter() {
        for filter in all() {
            // The sums err by a few cells of 1/65536 at the jumps of the weight, times the offset's power there.
            for (k, tolerance) in [(0, 1e-4), (1, 1e-4), (2, 3e-4), (4, 3e-3)] {
                let (drawn, exact) = (moment(&filter, k), by_quadrature(&filter, k));
                assert!((drawn - exact).abs() <= tolerance, "{filter}, moment {k}: {drawn} for {exact}");
            }
        }
    }

    #[test]
    fn positive_filters_leave_a_constant_as_it_is() {
        for filter in all() {
            let weights: Vec<f64> = (0..1000).map(|i| filter.sample(DVec2::splat(f64::from(i) / 1000.0)).1).collect();
            let signed = ["mitchell", "catmullrom", "lanczos"].iter().any(|name| filter.to_string().starts_with(name));
            assert_eq!(weights.iter().all(|w| *w == 1.0), !signed, "{filter}");
        }
    }

    #[test]
    fn offsets_fill_the_support_in_the_order_of_u() {
        for filter in all() {
            let x = |u: f64| filter.sample(DVec2::new(u, 0.5)).0.x;
            let r = filter.radius();
            assert!(x(0.0) >= -r && x(0.0) <= -0.99 * r && x(1.0 - f64::EPSILON / 2.0) <= r, "{filter}");
            assert!((1..1000).all(|i| x(f64::from(i - 1) / 1000.0) <= x(f64::from(i) / 1000.0)), "{filter}");
        }
        assert_eq!(Filter::BOX.sample(DVec2::new(0.0, 0.75)), (DVec2::new(-0.5, 0.25), 1.0));
    }

    #[test]
    fn published_values() {
        let at = |name: &str, x: f64| name.parse::<Filter>().unwrap().eval(DVec2::new(x, 0.0));
        let centre = |name: &str| at(name, 0.0).sqrt();
        // (6 − 2B)/6 at 0, B/6 at 1, and 0 from 2 on.
        assert_abs_diff_eq!(centre("mitchell"), 8.0 / 9.0, epsilon = 1e-15);
        assert_abs_diff_eq!(at("mitchell", 1.0) / centre("mitchell"), 1.0 / 18.0, epsilon = 1e-15);
        assert_eq!((at("mitchell", 2.0), at("catmullrom", 1.0), at("lanczos", 3.0)), (0.0, 0.0, 0.0));
        // Catmull-Rom at 1/2 is 9/16.
        assert_abs_diff_eq!(at("catmullrom", 0.5), 9.0 / 16.0, epsilon = 1e-15);
        let (one, last) = ((-2.0_f64).exp(), (-8.0_f64).exp());
        assert_abs_diff_eq!(at("gaussian", 1.0), (one - last) * (1.0 - last), epsilon = 1e-15);
    }

    #[test]
    fn tables_are_as_close_as_they_say() {
        for filter in all() {
            let Some(table) = &filter.table else { continue };
            let scale = table.magnitude.sample_pdf(0.0) / value(&filter.kind, 0.0);
            for i in 0..10_000 {
                let x = f64::from(i) / 10_000.0 * filter.radius();
                let error = (table.magnitude.sample_pdf(x) / scale - value(&filter.kind, x).abs()).abs();
                // At a zero of f, |f| has a corner that a cell cuts off: a cell's width times the slope there.
                assert!(error <= 1e-5 || value(&filter.kind, x).abs() <= 2e-3, "{filter} at {x}: {error}");
            }
        }
    }

    #[test]
    fn spelling() {
        for filter in all() {
            assert_eq!(filter.to_string().parse(), Ok(filter));
        }
        assert_eq!("mitchell:b=1/3,c=1/3".parse::<Filter>(), "mitchell".parse());
        for (typed, reason) in [
            ("boxx", "there is no such filter"),
            ("tent:width=2", "it has no parameter width"),
            ("tent:radius=0", "the radius must be in (0, 16]"),
            ("gaussian:stddev=NaN", "the radius must be in"),
            ("gaussian:stddev", "stddev is no key=value"),
            ("lanczos:lobes=2.5", "whole number"),
            ("mitchell:b=x", "x is no number"),
        ] {
            let error = typed.parse::<Filter>().unwrap_err().to_string();
            assert!(error.contains(reason) && error.contains("known are box"), "{typed}: {error}");
        }
    }
}
