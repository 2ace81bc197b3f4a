//! Closed rooms: every number of reflections, and all of them.

use std::f64::consts::{FRAC_1_PI, PI};

use crate::common::{
    Family, STRATEGIES, anywhere, diffuse, facing, named, onto, radiosity, scene, shape, towards, tracer,
};
use whitefurnace::bsdf::{Bsdf, Lambert, Lobes};
use whitefurnace::glam::{DVec2, DVec3};
use whitefurnace::integrate::Estimate;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::path::Strategy;
use whitefurnace::render::probe::Probe;
use whitefurnace::sampling::sampler::Sampler;
use whitefurnace::scene::builtin::{furnace_radiance, sphere_multiplier};
use whitefurnace::scene::{Geometry, Light, Material, Ray, Varying};

const SAMPLES: u64 = 30_000;

#[test]
fn furnaces_reflect_a_geometric_series() {
    let mut family = Family::default();
    for (s, name) in ["furnace-sphere", "furnace-box"].into_iter().enumerate() {
        let scene = named(name, &["rho=0.2/0.5/0.8", "e=0.8/0.5/0.2"]);
        for (k, strategy) in STRATEGIES.into_iter().enumerate() {
            for (j, bounces) in [Some(0), Some(1), Some(2), Some(5), None].into_iter().enumerate() {
                let number = (1000 + 100 * s + 10 * k + j) as u64;
                let probe = Probe { seed: 1, number, samples: 8192 };
                let tracer = tracer(strategy, bounces);
                let channels = probe.estimate(&tracer, &scene, &|sampler| {
                    Ray::new(DVec3::new(0.1, -0.3, 0.2), anywhere(sampler.next_2d()))
                });
                for (moments, (rho, e)) in channels.iter().zip([(0.2, 0.8), (0.5, 0.5), (0.8, 0.2)]) {
                    let exact = furnace_radiance(rho, e, bounces);
                    if strategy == Strategy::Bsdf && bounces.is_some() {
                        // No chance is left: every path brings the same. 1e-12 is a thousand roundings.
                        let spread = moments.variance().sqrt();
                        assert!(
                            (moments.mean() - exact).abs() < 1e-12 && spread < 1e-12,
                            "{name} {bounces:?}: {moments:?}"
                        );
                    }
                    family.add(
                        format!("{name} {strategy:?} {bounces:?} ρ {rho}"),
                        Estimate::from(moments),
                        exact,
                        1e-12,
                    );
                }
            }
        }
    }
    family.judge();
}

/// Reflects differently in every stripe of longitude.
#[derive(Debug)]
struct Stripes;

impl Varying for Stripes {
    fn at(&self, uv: DVec2, _: Rgb) -> Box<dyn Bsdf> {
        let rho =
            if ((4.0 * uv.x) as u32).is_multiple_of(2) { Rgb::new(0.2, 0.9, 0.5) } else { Rgb::new(0.8, 0.1, 0.0) };
        Box::new(Lambert::new(rho).expect("reflectances"))
    }

    fn lobes(&self) -> Lobes {
        Lobes::REFLECT
    }
}

#[test]
fn inside_a_sphere_only_the_means_count() {
    let mut family = Family::default();
    // An emitting black port over a tenth of the sphere, and stripes on the rest: H = mean(E) / (1 − mean(ρ)).
    let f = 0.1_f64;
    let mut port = facing(DVec3::Z * (1.0 - 2.0 * f), DVec3::NEG_Z, 1.0);
    port.matrix3.x_axis *= 2.0 * (f * (1.0 - f)).sqrt();
    port.matrix3.y_axis *= 2.0 * (f * (1.0 - f)).sqrt();
    let mut wall = shape("wall", Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }, 0, None);
    wall.flip_normals = true;
    let scene = scene(
        vec![Material::varying("stripes", Box::new(Stripes)), diffuse(0.0)],
        vec![wall, shape("port", Geometry::Disk { to_world: port }, 1, Some(FRAC_1_PI))],
        vec![],
    );
    let whole_stripes = [(0.1, [0.2, 0.9, 0.5]), (1.7, [0.8, 0.1, 0.0])];
    let mean = [0.5, 0.5, 0.25].map(|rho| (1.0 - f) * rho);
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        for (j, (phi, rho)) in whole_stripes.into_iter().enumerate() {
            let (s, c) = f64::sin_cos(phi);
            let p = DVec3::new(0.8 * c, 0.8 * s, -0.6);
            let probe = Probe { seed: 1, number: (1300 + 10 * k + j) as u64, samples: SAMPLES };
            let channels = probe.estimate(&tracer(strategy, None), &scene, &|_| onto(p, -p, 0.5));
            for channel in 0..3 {
                let h = f / (1.0 - mean[channel]);
                let label = format!("{strategy:?}, longitude {phi}, channel {channel}");
                family.add(label, Estimate::from(&channels[channel]), FRAC_1_PI * rho[channel] * h, 1e-12);
            }
        }
    }
    family.judge();
}

#[test]
fn an_integrating_sphere_multiplies() {
    let mut family = Family::default();
    for (j, (rho, f)) in [(0.9, 0.05), (0.98, 0.01), (0.5, 0.3)].into_iter().enumerate() {
        let scene = named("integrating-sphere", &[&format!("rho={rho}"), &format!("f={f}")]);
        for (k, strategy) in STRATEGIES.into_iter().enumerate() {
            let probe = Probe { seed: 1, number: (1400 + 10 * j + k) as u64, samples: SAMPLES };
            let [red, ..] = probe.estimate(&tracer(strategy, None), &scene, &|sampler| {
                scene.camera_ray(512.0 * sampler.next_2d(), DVec2::ZERO)
            });
            family.add(format!("ρ {rho}, f {f}, {strategy:?}"), Estimate::from(&red), sphere_multiplier(rho, f), 1e-12);
        }
    }
    family.judge();
}

#[test]
fn concentric_spheres_exchange_light() {
    let mut family = Family::default();
    let sphere = |radius| Geometry::Sphere { centre: DVec3::ZERO, radius };
    let mut outer = shape("outer", sphere(1.0), 1, None);
    outer.flip_normals = true;
    let inner = shape("inner", sphere(0.5), 0, Some(FRAC_1_PI));
    let scene = scene(vec![diffuse(0.3), diffuse(0.7)], vec![inner, outer], vec![]);
    for (k, strategy) in STRATEGIES.into_iter().enumerate() {
        let tracer = tracer(strategy, None);
        let number = 1500 + 10 * k as u64;
        let b1 = radiosity(number, SAMPLES, &tracer, &scene, &|s| {
            let n = anywhere(s.next_2d());
            onto(0.5 * n, n, 0.2)
        });
        let b2 = radiosity(number + 1, SAMPLES, &tracer, &scene, &|s| {
            let n = anywhere(s.next_2d());
            onto(n, -n, 0.2)
        });
        // Twelve digits are published.
        family.add(format!("inner, {strategy:?}"), b1, 1.12426035503, 5e-12);
        family.add(format!("outer, {strategy:?}"), b2, 0.414201183432, 5e-13);
    }
    family.judge();
}

#[test]
fn plates_without_end_exchange_light() {
    // Plates at a distance of 1, the lower one of radiosity 1 without the other: B₁ = Σ (ρ₁ρ₂)^k, B₂ = ρ₂ B₁ with one term
    // less where reflections are counted. A step goes farther than s with probability 1/(1 + s²), so that of k steps from
    // the middle of plates of half width R at most k³/R² leave; weighted by the reflectances, 2e-8 in all.
    const HALF_WIDTH: f64 = 1e5;
    let (rho1, rho2) = (0.5, 0.8);
    let plate = |z: f64, normal| Geometry::Rectangle { to_world: facing(DVec3::Z * z, normal, HALF_WIDTH) };
    let scene = scene(
        vec![diffuse(rho1), diffuse(rho2)],
        vec![
            shape("lower", plate(0.0, DVec3::Z), 0, Some(FRAC_1_PI)),
            shape("upper", plate(1.0, DVec3::NEG_Z), 1, None),
        ],
        vec![],
    );
    let series = |terms: i32| (0..terms).map(|k| (rho1 * rho2).powi(k)).sum::<f64>();
    let cases = [
        (Some(0), 1.0, 0.0),
        (Some(1), 1.0, rho2),
        (Some(4), series(3), rho2 * series(2)),
        (None, 1.0 / (1.0 - rho1 * rho2), rho2 / (1.0 - rho1 * rho2)),
    ];
    let mut family = Family::default();
    for (j, (bounces, lower, upper)) in cases.into_iter().enumerate() {
        for (k, strategy) in STRATEGIES.into_iter().enumerate() {
            let tracer = tracer(strategy, bounces);
            let number = (1700 + 20 * j + 2 * k) as u64;
            let b1 = radiosity(number, SAMPLES, &tracer, &scene, &|_| onto(DVec3::ZERO, DVec3::Z, 0.2));
            let b2 = radiosity(number + 1, SAMPLES, &tracer, &scene, &|_| onto(DVec3::Z, DVec3::NEG_Z, 0.2));
            family.add(format!("lower, {strategy:?}, {bounces:?}"), b1, lower, 2e-8);
            family.add(format!("upper, {strategy:?}, {bounces:?}"), b2, upper, 2e-8);
        }
    }
    family.judge();
}

#[test]
fn a_point_light_in_a_sphere_is_exact() {
    // Intensity π in the middle of a unit sphere of reflectance 1/2: 1/2, 3/4, 7/8, …, 1.
    let mut wall = shape("wall", Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }, 0, None);
    wall.flip_normals = true;
    let light = Light::Point { position: DVec3::ZERO, intensity: Rgb::grey(PI) };
    let scene = scene(vec![diffuse(0.5)], vec![wall], vec![light]);
    let ray = |s: &mut dyn Sampler| Ray::new(DVec3::new(0.2, 0.1, -0.3), anywhere(s.next_2d()));
    let mut family = Family::default();
    for bounces in 0..6 {
        let exact = 1.0 - 0.5_f64.powi(bounces);
        for (k, strategy) in STRATEGIES.into_iter().enumerate() {
            let number = (1600 + 10 * bounces as usize + k) as u64;
            let probe = Probe { seed: 1, number, samples: 4096 };
            let [red, ..] = probe.estimate(&tracer(strategy, Some(bounces as u32)), &scene, &ray);
            match strategy {
                // What no path can hit is never found.
                Strategy::Bsdf => assert_eq!(red.mean(), 0.0),
                // Every connection brings the same. 1e-12 is a thousand roundings.
                Strategy::Mis | Strategy::Direct => {
                    assert!((red.mean() - exact).abs() < 1e-12 && red.variance().sqrt() < 1e-12, "{bounces}: {red:?}");
                }
                Strategy::RandomConnect => family.add(format!("{bounces}"), Estimate::from(&red), exact, 1e-12),
            }
        }
    }
    family.judge();
}

/// Radiosities of the bottom, the top and a side of `cube-one-emitter` for ρ = 1/2 after so many reflections.
const CUBE: [(Option<u32>, [f64; 3]); 4] = [
    (Some(1), [1.0, 0.0999124478, 0.1000218880]),
    (Some(2), [1.063938, 0.129263, 0.139200]),
    (Some(3), [1.082722, 0.151010, 0.160317]),
    (None, [1.104362, 0.171216, 0.181106]),
];

fn cube(family: &mut Family, samples: u64) {
    let scene = named("cube-one-emitter", &["rho=0.5"]);
    let eye = DVec3::new(0.4, 0.5, 0.55);
    let faces = [(DVec3::ZERO, DVec3::X, DVec3::Y), (DVec3::Z, DVec3::X, DVec3::Y), (DVec3::X, DVec3::Y, DVec3::Z)];
    for (j, (bounces, exact)) in CUBE.into_iter().enumerate() {
        for (k, strategy) in STRATEGIES.into_iter().enumerate() {
            for (face, (corner, x, y)) in faces.into_iter().enumerate() {
                let number = (2000 + 100 * j + 10 * k + face) as u64;
                let b = radiosity(number, samples, &tracer(strategy, bounces), &scene, &|s| {
                    towards(eye, corner, x, y, s.next_2d())
                });
                // One reflection is known to ten digits, the others to six.
                let error = if bounces == Some(1) { 5e-11 } else { 5e-7 };
                family.add(format!("{strategy:?}, {bounces:?} reflections, face {face}"), b, exact[face], error);
            }
        }
    }
}

#[test]
fn a_cube_with_one_emitter() {
    let mut family = Family::default();
    cube(&mut family, SAMPLES);
    family.judge();
}

#[test]
#[ignore = "minutes"]
fn a_cube_with_one_emitter_to_three_ten_thousandths() {
    let mut family = Family::default();
    cube(&mut family, 2_000_000);
    family.judge();
}
