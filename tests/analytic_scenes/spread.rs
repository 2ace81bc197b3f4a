//! The spread of single samples: six estimators whose standard deviation is known, and the law of splitting.

use std::f64::consts::FRAC_1_PI;

use crate::common::{Family, diffuse, facing, named, onto, radiosity, scene, shape, tracer};
use whitefurnace::bsdf::{Bsdf, BsdfSample, Uniforms};
use whitefurnace::glam::DVec3;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::path::{Heuristic, PathTracer, Strategy};
use whitefurnace::render::probe::Probe;
use whitefurnace::sampling::warp::uniform_hemisphere;
use whitefurnace::scene::{Geometry, LightSampling, Material};

/// Lambert's reflection of all light, drawn uniformly over the hemisphere.
#[derive(Debug)]
struct UniformlySampled;

impl Bsdf for UniformlySampled {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        Rgb::grey(if wo.z > 0.0 && wi.z > 0.0 { FRAC_1_PI } else { 0.0 })
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z > 0.0 && wi.z > 0.0 { 0.5 * FRAC_1_PI } else { 0.0 }
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let wi = uniform_hemisphere(u.dir);
        BsdfSample::new(wi, self.eval(wo, wi), self.pdf(wo, wi))
    }
}

/// The unit square light over the point below its centre, by the six usual estimators, with their standard deviations.
fn six_sigmas(family: &mut Family, samples: impl Fn(f64) -> u64) {
    let white = Material::diffuse("white", Rgb::WHITE.into());
    let square = facing(DVec3::new(0.5, 0.5, 1.0), DVec3::NEG_Z, 0.5);
    let floor = facing(DVec3::new(0.5, 0.5, 0.0), DVec3::Z, 1.0);
    let over = |material| {
        scene(
            vec![material, diffuse(0.0)],
            vec![
                shape("floor", Geometry::Rectangle { to_world: floor }, 0, None),
                shape("light", Geometry::Rectangle { to_world: square }, 1, Some(1.0)),
            ],
            vec![],
        )
    };
    let (cosine, uniform) = (over(white), over(Material::uniform("uniform", Box::new(UniformlySampled))));
    let by =
        |strategy, light_sampling, heuristic| PathTracer { light_sampling, heuristic, ..tracer(strategy, Some(1)) };
    let (area, solid_angle) = (LightSampling::Area, LightSampling::SolidAngle);
    let cases = [
        ("area", by(Strategy::Direct, area, Heuristic::Balance), &cosine, 0.1310654085),
        ("solid angle", by(Strategy::Direct, solid_angle, Heuristic::Balance), &cosine, 0.0325582572),
        ("cosine", by(Strategy::Bsdf, area, Heuristic::Balance), &cosine, 1.340680211),
        ("uniform", by(Strategy::Bsdf, area, Heuristic::Balance), &uniform, 1.963945333),
        ("balance", by(Strategy::Mis, area, Heuristic::Balance), &cosine, 0.2806361183),
        ("power", by(Strategy::Mis, area, Heuristic::Power), &cosine, 0.1380502427),
    ];
    for (i, (name, tracer, scene, sigma)) in cases.into_iter().enumerate() {
        let n = samples(sigma);
        let p = DVec3::new(0.5, 0.5, 0.0);
        let e = radiosity(3000 + i as u64, n, &tracer, scene, &|_| onto(p, DVec3::Z, 0.5));
        let found = e.std_err * (e.n as f64).sqrt();
        assert!((found / sigma - 1.0).abs() < 0.02, "{name}: σ {found} against {sigma}");
        family.add(name, e, 0.752274688454, 1e-12);
    }
}

#[test]
fn six_estimators_have_their_standard_deviations() {
    let mut family = Family::default();
    six_sigmas(&mut family, |_| 200_000);
    family.judge();
}

#[test]
#[ignore = "minutes"]
fn six_estimators_have_their_means_to_three_ten_thousandths() {
    let mut family = Family::default();
    six_sigmas(&mut family, |sigma| 1_000_000.max((sigma / 2.9e-4_f64).powi(2) as u64));
    family.judge();
}

/// Irradiance on the floor at (x, y) from the unit square at height 1: Lambert's sum over its four edges.
fn from_the_unit_square(x: f64, y: f64) -> f64 {
    let corners =
        [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(a, b)| DVec3::new(a - x, b - y, 1.0).normalize());
    let edges = (0..4).map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        a.angle_between(b) * a.cross(b).normalize().z
    });
    0.5 * edges.sum::<f64>().abs()
}

#[test]
fn splitting_divides_what_comes_after_the_first_surface() {
    assert!((from_the_unit_square(0.5, 0.5) - 0.752274688454).abs() < 1e-12);
    let scene = named("unit-square-light", &["rho=1"]);
    // A pixel of the floor, x in [−1, 1] at y = ½: V₀ is the variance of E/π within it.
    let (mut first, mut second, steps) = (0.0, 0.0, 2000);
    for i in 0..steps {
        let l = FRAC_1_PI * from_the_unit_square(-1.0 + (f64::from(i) + 0.5) / 1000.0, 0.5);
        (first, second) = (first + l / f64::from(steps), second + l * l / f64::from(steps));
    }
    let v0 = second - first * first;
    let variance = |number, first_split| {
        let tracer = PathTracer { first_split, ..tracer(Strategy::Bsdf, Some(1)) };
        let probe = Probe { seed: 1, number, samples: 100_000 };
        let [red, ..] = probe.estimate(&tracer, &scene, &|s| {
            let p = DVec3::new(-1.0 + 2.0 * s.next_1d(), 0.5, 0.0);
            onto(p, DVec3::Z, 0.1)
        });
        // 4 standard errors: 1 in 16 000 seeds.
        assert!((red.mean() - first).abs() < 4.0 * red.std_err(), "{first_split}: {red:?} against {first}");
        red.variance()
    };
    let v1 = variance(3100, 1) - v0;
    for (i, split) in [2, 4, 16].into_iter().enumerate() {
        let (found, law) = (variance(3101 + i as u64, split), v0 + v1 / f64::from(split));
        // A variance of 1e5 samples with the kurtosis of a coin is known to 1 %; both sides have that.
        assert!((found / law - 1.0).abs() < 0.04, "split {split}: {found} against {law}");
    }
}
