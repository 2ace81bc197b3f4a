//! One light above a floor: direct light in closed form.

use glam::DVec3;

use super::Builtin;
use super::parts::{emitting, faces, placed, scene, shape};
use crate::bsdf::Domain;
use crate::bsdf::subject::ParamSpec;
use crate::math::color::Rgb;
use crate::scene::{Camera, Geometry, Material, Shape};

const RHO: ParamSpec = ParamSpec::new("rho", Domain::Colour(0.0, 1.0), "reflectance of the floor").or("0.5");
const RADIUS: ParamSpec = ParamSpec::new("radius", Domain::Closed(1e-6, 3.9), "radius of the sphere").or("1");

pub(super) const SPHERE_LIGHT: Builtin = Builtin {
    name: "sphere-light",
    summary: "a black sphere of radiance 1 with its centre 4 above a floor",
    params: &[RHO, RADIUS],
    closed_form: Some(
        "a point of the floor at distance d from the centre is rho (radius / d)^2 (4 / d), in the view from above",
    ),
    build: |args| {
        let (rho, radius) = (args.colour("rho")?, args.number("radius")?);
        let sphere = Geometry::Sphere { centre: DVec3::Z * 4.0, radius };
        let shapes = vec![floor(DVec3::ZERO, 20.0), emitting(shape("light", sphere, 1), Rgb::WHITE)];
        let camera = Camera::look_at(DVec3::new(0.0, -12.0, 6.0), DVec3::new(0.0, 0.0, 1.0), DVec3::Z, 50.0);
        Ok(scene("sphere-light", camera, vec![diffuse_floor(rho), black()], shapes))
    },
};

pub(super) const UNIT_SQUARE_LIGHT: Builtin = Builtin {
    name: "unit-square-light",
    summary: "the black unit square at height 1, of radiance 1 downwards, above a floor",
    params: &[RHO],
    closed_form: Some(
        "the floor's irradiance is .752274688454 at (.5, .5), .435209875684 at (0, 0), .0362499303545 at (-1, -1)",
    ),
    build: |args| {
        let (v, rho) = (DVec3::new, args.colour("rho")?);
        // Counter-clockwise seen from below.
        let square = [v(0.0, 0.0, 1.0), v(0.0, 1.0, 1.0), v(1.0, 1.0, 1.0), v(1.0, 0.0, 1.0)];
        let centre = v(0.5, 0.5, 0.0);
        let shapes = vec![floor(centre, 10.0), emitting(shape("light", faces(&[square]), 1), Rgb::WHITE)];
        let camera = Camera::look_at(v(0.5, -4.0, 2.5), v(0.5, 0.5, 0.2), DVec3::Z, 45.0);
        Ok(scene("unit-square-light", camera, vec![diffuse_floor(rho), black()], shapes))
    },
};

/// A square in the plane z = 0 that faces up.
fn floor(centre: DVec3, half_side: f64) -> Shape {
    let axes = [DVec3::X * half_side, DVec3::Y * half_side, DVec3::Z];
    shape("floor", Geometry::Rectangle { to_world: placed(centre, axes) }, 0)
}

fn diffuse_floor(rho: Rgb) -> Material {
    Material::diffuse("floor", rho.into())
}

fn black() -> Material {
    Material::diffuse("black", Rgb::BLACK.into())
}
