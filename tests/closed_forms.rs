//! Published numbers that concern no single model's file: averages, a model without masking, and where gains begin.

use whitefurnace::bsdf::{Bsdf, subject};
use whitefurnace::glam::DVec3;
use whitefurnace::integrate::{Hemisphere, Side};
use whitefurnace::math::sphere::direction_mu;
use whitefurnace::prelude::{FnBsdf, Ggx, Rgb};

fn albedo(bsdf: &dyn Bsdf, side: Side, mu: f64) -> f64 {
    let a = Hemisphere::with_tol(1e-8).albedo(bsdf, side, direction_mu(mu, 0.2));
    assert!(a.resolved, "{mu}: {a:?}");
    a.value.0.x
}

/// GGX with F = 1 and no masking at all: D / (4 μo μi).
fn unmasked(alpha: f64) -> FnBsdf<impl Fn(DVec3, DVec3) -> Rgb + Send + Sync> {
    FnBsdf::new("unmasked ggx", move |wo: DVec3, wi: DVec3| {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::BLACK;
        }
        let h = wo + wi;
        let tan2 = (h.x * h.x + h.y * h.y) / (h.z * h.z);
        let cos2 = 1.0 / (1.0 + tan2);
        let d = 1.0 / (std::f64::consts::PI * alpha * alpha * cos2 * cos2 * (1.0 + tan2 / (alpha * alpha)).powi(2));
        Rgb::grey(d / (4.0 * wo.z * wi.z))
    })
}

#[test]
fn without_masking_ggx_gains_only_near_grazing() {
    for (alpha, values) in
        [(0.1, [0.990_099, 0.991_416, 1.162_701, 5.513_358]), (0.5, [0.8, 0.974_836, 2.896_045, 25.377_109])]
    {
        let model = unmasked(alpha);
        for (mu, exact) in [1.0, 0.5, 0.1, 0.01].into_iter().zip(values) {
            for side in [Side::Eye, Side::Light] {
                // Six decimals are given.
                assert!((albedo(&model, side, mu) - exact).abs() <= 6e-7 * exact.max(1.0), "alpha {alpha} mu {mu}");
            }
        }
    }
}

#[test]
fn averages_of_ggx() {
    let correlated = [(0.1, 0.972_045_76), (0.25, 0.882_323_38), (0.5, 0.700_240_47), (1.0, 0.409_137_092_587)];
    let separable = [(0.1, 0.971_559_48), (0.25, 0.879_455_67), (0.5, 0.689_402_71), (1.0, 0.376_634_611_193)];
    for (suffix, table) in [("", correlated), (",g=separable", separable)] {
        for (alpha, exact) in table {
            let model = subject::parse(&format!("ggx:alpha={alpha}{suffix}")).unwrap();
            let average = Hemisphere::with_tol(1e-8).average(&*model, Side::Eye);
            // Eight decimals are given.
            let gap = (average.value.0.x - exact).abs();
            assert!(average.resolved && gap <= 2e-8, "{alpha}{suffix}: {average:?} {exact}");
        }
    }
}

#[test]
fn where_the_lecture_s_second_phong_begins_to_gain() {
    let model = subject::parse("phong:n=100,kd=0,ks=1,norm=n+1,divide=true").unwrap();
    for (degrees, exact) in [(80.0_f64, 0.999_231), (85.0, 1.109_007), (89.0, 2.787_223)] {
        let light = albedo(&*model, Side::Light, degrees.to_radians().cos());
        assert!((light - exact).abs() <= 6e-7 * exact, "{degrees}: {light}");
        assert!(albedo(&*model, Side::Eye, degrees.to_radians().cos()) <= 1.0);
    }
}

#[test]
fn albedo_is_monotone_neither_in_angle_nor_in_width() {
    let (narrow, wide) = (Ggx::new(0.01).unwrap(), Ggx::new(0.05).unwrap());
    let (a, b) = (albedo(&narrow, Side::Eye, 0.01), albedo(&wide, Side::Eye, 0.01));
    assert!((a - 0.891_987_352).abs() <= 2e-8, "{a}");
    assert!(b > a && (1.0 - b - 0.04).abs() < 0.005, "the wider lobe loses about 4 %: {b}");
}
