//! Direct light of squares, disks, spheres and the lights of two Cornell boxes, by every strategy.

use std::f64::consts::PI;

use crate::common::{Family, STRATEGIES, diffuse, facing, named, onto, radiosity, scene, shape, tracer};
use whitefurnace::glam::DVec3;
use whitefurnace::integrate::Estimate;
use whitefurnace::scene::{Geometry, Scene};

const SAMPLES: u64 = 30_000;

/// Irradiance at points of diffuse receivers, by every strategy, each with its own number from `first` on.
fn irradiances(family: &mut Family, first: u64, scene: &Scene, rho: f64, points: &[(DVec3, DVec3, f64, f64)]) {
    for (i, &(p, n, exact, error)) in points.iter().enumerate() {
        for (k, strategy) in STRATEGIES.into_iter().enumerate() {
            let number = first + (4 * i + k) as u64;
            let reach = 0.05 * (1.0 + p.length() * 1e-2);
            let b = radiosity(number, SAMPLES, &tracer(strategy, Some(1)), scene, &|_| onto(p, n, reach));
            let h = Estimate { mean: b.mean / rho, std_err: b.std_err / rho, n: b.n };
            family.add(format!("{strategy:?} at {p}"), h, exact, error);
        }
    }
}

#[test]
fn irradiance_from_the_unit_square() {
    let mut family = Family::default();
    let z = DVec3::Z;
    let points = [
        (DVec3::new(0.5, 0.5, 0.0), z, 0.752274688454, 1e-12),
        (DVec3::new(0.0, 0.0, 0.0), z, 0.435209875684, 1e-12),
        (DVec3::new(-1.0, -1.0, 0.0), z, 0.0362499303545, 1e-12),
    ];
    irradiances(&mut family, 100, &named("unit-square-light", &["rho=0.8"]), 0.8, &points);
    // A receiver whose horizon cuts the square: light from behind it must not count, nor negative cosines.
    let p = DVec3::new(0.25, 0.5, 0.0);
    let square = facing(DVec3::new(0.5, 0.5, 1.0), DVec3::NEG_Z, 0.5);
    let upright = scene(
        vec![diffuse(0.8), diffuse(0.0)],
        vec![
            shape("receiver", Geometry::Disk { to_world: facing(p, DVec3::X, 1e-3) }, 0, None),
            shape("light", Geometry::Rectangle { to_world: square }, 1, Some(1.0)),
        ],
        vec![],
    );
    irradiances(&mut family, 200, &upright, 0.8, &[(p, DVec3::X, 0.159242507311, 1e-12)]);
    family.judge();
}

#[test]
fn irradiance_from_disks_and_spheres() {
    let mut family = Family::default();
    // A disk of radius 1 at height 1, looked at from offsets of 0, .5 and 1; E = π times the published factor.
    let lit_by = |light: Geometry, p: DVec3, n: DVec3| {
        scene(
            vec![diffuse(0.8), diffuse(0.0)],
            vec![
                shape("receiver", Geometry::Disk { to_world: facing(p, n, 1e-3) }, 0, None),
                shape("light", light, 1, Some(1.0)),
            ],
            vec![],
        )
    };
    for (i, (offset, factor)) in [(0.0, 0.5), (0.5, 0.437982632705), (1.0, 0.276393202250)].into_iter().enumerate() {
        let disk = Geometry::Disk { to_world: facing(DVec3::Z, DVec3::NEG_Z, 1.0) };
        let p = DVec3::X * offset;
        let points = [(p, DVec3::Z, PI * factor, 1e-11)];
        irradiances(&mut family, 300 + 10 * i as u64, &lit_by(disk, p, DVec3::Z), 0.8, &points);
    }
    // A sphere of s = r/d = .25 under receivers that tilt until it sinks below their horizon.
    let tilted = [(0.0, 0.196349540849), (30.0, 0.170043690397), (60.0, 0.0981747704247), (90.0, 0.0106187960041)];
    for (i, (degrees, exact)) in tilted.into_iter().enumerate() {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let n = DVec3::new(sin, 0.0, cos);
        let sphere = Geometry::Sphere { centre: DVec3::Z * 4.0, radius: 1.0 };
        irradiances(
            &mut family,
            400 + 10 * i as u64,
            &lit_by(sphere, DVec3::ZERO, n),
            0.8,
            &[(DVec3::ZERO, n, exact, 1e-12)],
        );
    }
    family.judge();
}

#[test]
fn irradiance_in_both_cornell_boxes() {
    let mut family = Family::default();
    let v = DVec3::new;
    let places = [
        (v(278.0, 400.0, 559.2), DVec3::NEG_Z, 0.0564689832, 0.0564534009),
        (v(100.0, 450.0, 559.2), DVec3::NEG_Z, 0.0271134669, 0.0270237529),
        (v(0.0, 400.0, 279.6), DVec3::X, 0.0586574891, 0.0586495439),
        (v(368.5, 330.0, 351.25), DVec3::Y, 0.169954967, 0.170406720),
        (v(185.5, 165.0, 169.0), DVec3::Y, 0.0699268476, 0.0700628816),
    ];
    for (box_number, name) in ["cornell-original", "cornell-mitsuba"].into_iter().enumerate() {
        let scene = named(name, &[]);
        for (i, &(p, n, original, mitsuba)) in places.iter().enumerate() {
            let exact = [original, mitsuba][box_number];
            for (k, strategy) in STRATEGIES.into_iter().enumerate() {
                let number = (500 + 100 * box_number + 4 * i + k) as u64;
                let b = radiosity(number, SAMPLES, &tracer(strategy, Some(1)), &scene, &|_| onto(p, n, 1.0));
                // The red channel of what is there and of the light.
                let surface = scene.intersect(&onto(p, n, 1.0)).expect("a wall");
                let rho = scene.material_of(surface.shape).lambertian().expect("a diffuse wall").0.x;
                let light = scene.shapes().iter().find_map(|shape| shape.emission).expect("a light").0.x;
                let h = Estimate { mean: b.mean / (rho * light), std_err: b.std_err / (rho * light), n: b.n };
                // Half a unit of the last of nine digits.
                family.add(format!("{name} {strategy:?} at {p}"), h, exact, 5e-10);
            }
        }
    }
    family.judge();
}
