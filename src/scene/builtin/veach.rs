//! Veach's plates: four rough mirrors under three spheres of the same power, from large to small.
//!
//! The numbers are those of Bitterli's edition, whose reference image has direct light only.
//! # References
//! - Veach & Guibas 1995, Optimally combining sampling techniques for Monte Carlo rendering, SIGGRAPH
//! - Bitterli 2016, Rendering resources, benedikt-bitterli.me/resources

use glam::DVec3;

use super::Builtin;
use super::parts::{emitting, placed, scene, shape};
use crate::bsdf::{Beckmann, Fresnel, Masking, ParamError};
use crate::math::color::Rgb;
use crate::sampling::filter::Filter;
use crate::scene::{Camera, Geometry, Material, RenderSettings};

const ETA: Rgb = Rgb::new(0.200438, 0.924033, 1.10221);
const K: Rgb = Rgb::new(3.91295, 2.45285, 2.14219);
/// Multiplies what the plates reflect.
const TINT: f64 = 0.3;

pub(super) const MIS: Builtin = Builtin {
    name: "veach-mis",
    summary: "Veach's plates in Bitterli's edition: Beckmann conductors of widths .01 to .25 under spheres, direct light",
    params: &[],
    closed_form: None,
    build: |_| {
        let v = DVec3::new;
        let mut materials = vec![
            Material::diffuse("diffuse", Rgb::grey(0.5).into()).two_sided(),
            Material::diffuse("light", Rgb::BLACK.into()).two_sided(),
        ];
        // Name, slope width, two half sides and the centre of each plate.
        let plates = [
            ("smooth", 0.01, (0.805757, -0.673242), (0.0961775, 0.115108), (0.264069, 4.09801)),
            ("glossy", 0.05, (0.972057, -0.396994), (0.0567134, 0.138865), (3.06163, 2.71702)),
            ("rough", 0.1, (1.03191, -0.194077), (0.0277252, 0.147415), (7.09981, 1.81891)),
            ("super-rough", 0.25, (1.04217, -0.127982), (0.0182831, 0.148882), (10.6769, 1.23376)),
        ];
        let wall = |centre, axes| Geometry::Rectangle { to_world: placed(centre, axes) };
        let mut shapes = vec![
            shape("floor", wall(v(4.9, 0.0, 0.0), [v(9.9, 0.0, 0.0), v(0.0, 0.0, -23.76), v(0.0, 9.9, 0.0)]), 0),
            shape("back", wall(v(-5.0, 9.9, 0.0), [v(0.0, -9.9, 0.0), v(0.0, 0.0, -23.76), v(9.9, 0.0, 0.0)]), 0),
        ];
        for (name, alpha, along, across, centre) in plates {
            let plate = plate(alpha)?;
            shapes.push(shape(
                name,
                Geometry::Cube {
                    to_world: placed(
                        v(centre.0, centre.1, 0.0),
                        [v(along.0, along.1, 0.0), v(across.0, across.1, 0.0), v(0.0, 0.0, 4.0)],
                    ),
                },
                materials.len(),
            ));
            materials.push(Material::uniform(name, Box::new(plate)).two_sided());
        }
        for (name, z, radius, radiance) in
            [("large-light", -2.8, 1.0, 7.59909), ("light", 0.0, 0.5, 30.3964), ("small-light", 2.7, 0.05, 3039.64)]
        {
            let sphere = Geometry::Sphere { centre: v(0.0, 6.5, z), radius };
            shapes.push(emitting(shape(name, sphere, 1), Rgb::grey(radiance)));
        }
        let eye = v(28.2792, 3.5, 0.0);
        let mut scene = scene("veach-mis", Camera::look_at(eye, eye - DVec3::X, DVec3::Y, 35.0), materials, shapes);
        (scene.film.width, scene.film.height, scene.film.filter) = (1280, 720, Filter::TENT);
        scene.render = RenderSettings { samples: Some(64), bounces: Some(Some(1)), roulette_from: None };
        Ok(scene)
    },
};

/// A conductor that reflects less than physics says, by [`TINT`].
fn plate(alpha: f64) -> Result<Beckmann, ParamError> {
    let fresnel = Fresnel::Conductor { eta: ETA, k: K };
    Beckmann::new(alpha)?.with_masking(Masking::Separable).with_fresnel(fresnel)?.with_tint(TINT)
}
