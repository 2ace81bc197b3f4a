//! Closed rooms in which light reflected any number of times has a closed form.

use std::f64::consts::FRAC_1_PI;

use glam::{DAffine3, DVec3};

use super::Builtin;
use super::parts::{emitting, faces, inside_out, placed, scene, shape};
use crate::bsdf::Domain;
use crate::bsdf::subject::{Args, ParamSpec, SubjectError};
use crate::math::color::Rgb;
use crate::scene::{Camera, Geometry, Material, SceneDescription};

const RHO: ParamSpec = ParamSpec::new("rho", Domain::Colour(0.0, 1.0), "reflectance of the walls").or("0.5");
const E: ParamSpec = ParamSpec::new("e", Domain::Colour(0.0, f64::INFINITY), "radiance emitted by the walls").or("0.5");
const F: ParamSpec = ParamSpec::new("f", Domain::Closed(1e-6, 0.5), "share of the sphere that is the port").or("0.05");

/// Radiance in a closed room whose walls emit the radiance `e` and reflect `rho`, after at most `reflections`
/// reflections: e (1 + ρ + … + ρʳ); without a limit e / (1 − ρ), which is infinite for ρ = 1.
///
/// It is the same everywhere, whatever the shape of the room.
pub fn furnace_radiance(rho: f64, e: f64, reflections: Option<u32>) -> f64 {
    match reflections {
        None => e / (1.0 - rho),
        Some(r) if rho == 1.0 => e * (f64::from(r) + 1.0),
        Some(r) => e * (1.0 - rho.powf(f64::from(r) + 1.0)) / (1.0 - rho),
    }
}

/// M = ρ / (1 − ρ (1 − f)): how much brighter the wall of a sphere of reflectance ρ is than a perfectly white surface under
/// the light that it receives at first, where the share `f` of the sphere is black.
///
/// # References
/// - Jacquez & Kuppenheim 1955, Theory of the integrating sphere, J. Opt. Soc. Am. 45(6)
pub fn sphere_multiplier(rho: f64, f: f64) -> f64 {
    rho / (1.0 - rho * (1.0 - f))
}

pub(super) const FURNACE_SPHERE: Builtin = Builtin {
    name: "furnace-sphere",
    summary: "the inside of a sphere that emits and reflects alike everywhere",
    params: &[RHO, E],
    closed_form: Some(
        "every pixel is e (1 - rho^(r+1)) / (1 - rho) after r reflections, e / (1 - rho) without a limit",
    ),
    build: |args| furnace("furnace-sphere", Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }, args),
};

pub(super) const FURNACE_BOX: Builtin = Builtin {
    name: "furnace-box",
    summary: "the inside of a cube that emits and reflects alike everywhere",
    params: &[RHO, E],
    closed_form: Some(
        "every pixel is e (1 - rho^(r+1)) / (1 - rho) after r reflections, e / (1 - rho) without a limit",
    ),
    build: |args| furnace("furnace-box", Geometry::Cube { to_world: DAffine3::IDENTITY }, args),
};

fn furnace(name: &str, geometry: Geometry, args: &Args) -> Result<SceneDescription, SubjectError> {
    let wall = Material::diffuse("wall", args.colour("rho")?.into());
    let shape = emitting(inside_out(shape("wall", geometry, 0)), args.colour("e")?);
    // Off the centre, where a mistake in a direction would show.
    let eye = DVec3::new(0.1, -0.2, 0.3);
    let camera = Camera::look_at(eye, eye + DVec3::new(1.0, 2.0, -0.5), DVec3::Z, 90.0);
    Ok(scene(name, camera, vec![wall], vec![shape]))
}

pub(super) const INTEGRATING_SPHERE: Builtin = Builtin {
    name: "integrating-sphere",
    summary: "a white sphere with a black port that emits radiance 1/f, so that the wall at first receives that of 1",
    params: &[ParamSpec { default: Some("0.9"), ..RHO }, F],
    closed_form: Some("every pixel is M = rho / (1 - rho (1 - f)); 6.206896552 for rho = .9, f = .05"),
    build: |args| {
        let (rho, f) = (args.colour("rho")?, args.number("f")?);
        let materials = vec![Material::diffuse("wall", rho.into()), Material::diffuse("port", Rgb::BLACK.into())];
        // A flat disk closes off the cap of height 2f, whose share of the area is f; 1 − (1 − 2f)² is its squared radius.
        // What lies behind it is never seen.
        let radius = 2.0 * (f * (1.0 - f)).sqrt();
        let height = 1.0 - 2.0 * f;
        let axes = [DVec3::X * radius, DVec3::NEG_Y * radius, DVec3::NEG_Z];
        let port = shape("port", Geometry::Disk { to_world: placed(DVec3::Z * height, axes) }, 1);
        let wall = inside_out(shape("wall", Geometry::Sphere { centre: DVec3::ZERO, radius: 1.0 }, 0));
        let shapes = vec![wall, emitting(port, Rgb::grey(1.0 / f))];
        let camera = Camera::look_at(DVec3::new(0.1, 0.2, 0.0), DVec3::new(0.1, 0.2, -1.0), DVec3::Y, 60.0);
        Ok(scene("integrating-sphere", camera, materials, shapes))
    },
};

pub(super) const CUBE_ONE_EMITTER: Builtin = Builtin {
    name: "cube-one-emitter",
    summary: "a closed unit cube whose bottom emits the radiosity 1",
    params: &[RHO],
    closed_form: Some(
        "mean radiosity of bottom, top and sides for rho = .5: 1.104362, .171216, .181106; \
         after one reflection 1, .0999124478, .100021888",
    ),
    build: |args| {
        let wall = Material::diffuse("wall", args.colour("rho")?.into());
        let names = ["bottom", "top", "left", "right", "front", "back"];
        let shapes = names.iter().zip(unit_cube_from_inside()).map(|(name, corners)| shape(name, faces(&[corners]), 0));
        let mut shapes: Vec<_> = shapes.collect();
        shapes[0].emission = Some(Rgb::grey(FRAC_1_PI));
        let eye = DVec3::new(0.5, 0.02, 0.6);
        let camera = Camera::look_at(eye, DVec3::new(0.5, 1.0, 0.35), DVec3::Z, 80.0);
        Ok(scene("cube-one-emitter", camera, vec![wall], shapes))
    },
};

/// The faces z = 0, z = 1, x = 0, x = 1, y = 0, y = 1 of the unit cube, seen from inside.
fn unit_cube_from_inside() -> [[DVec3; 4]; 6] {
    let corner = |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6]].map(|face| face.map(corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_faces_of_the_cube_face_inwards() {
        for [a, b, c, d] in unit_cube_from_inside() {
            let normal = (b - a).cross(c - a);
            assert_eq!(normal.length(), 1.0);
            assert_eq!((c - a).cross(d - a), normal);
            assert!(normal.dot(DVec3::splat(0.5) - a) > 0.0);
        }
    }

    #[test]
    fn the_furnace_series_is_the_sum_of_its_terms() {
        let mut sum = 0.0;
        for r in 0..8 {
            sum += 0.3 * 0.7_f64.powi(r);
            assert!((furnace_radiance(0.7, 0.3, Some(r as u32)) - sum).abs() < 1e-15);
            assert!((furnace_radiance(1.0, 0.3, Some(r as u32)) - 0.3 * f64::from(r + 1)).abs() < 1e-15);
        }
        assert!(
            (furnace_radiance(0.7, 0.3, None) - 1.0).abs() < 1e-15 && furnace_radiance(1.0, 1.0, None).is_infinite()
        );
        assert!((sphere_multiplier(0.9, 0.05) - 6.206896552).abs() < 5e-10, "ten digits are published");
    }
}
