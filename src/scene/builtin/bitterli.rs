//! The Cornell box of Bitterli's rendering resources: a cube of side 2 with its own proportions and colours.
//!
//! # References
//! - Bitterli 2016, Rendering resources, benedikt-bitterli.me/resources

use glam::DVec3;

use super::Builtin;
use super::parts::{emitting, placed, scene, shape};
use crate::math::color::Rgb;
use crate::sampling::filter::Filter;
use crate::scene::{Camera, Geometry, Material, RenderSettings};

pub(super) const CORNELL: Builtin = Builtin {
    name: "cornell-bitterli",
    summary: "the Cornell box of Bitterli's rendering resources: a cube of side 2, all surfaces two-sided",
    params: &[],
    closed_form: None,
    build: |_| {
        let white = Rgb::new(0.725, 0.71, 0.68);
        let colours = [
            ("white", white),
            ("left", Rgb::new(0.63, 0.065, 0.05)),
            ("right", Rgb::new(0.14, 0.45, 0.091)),
            ("light", Rgb::BLACK),
        ];
        let materials = colours.map(|(name, rho)| Material::diffuse(name, rho.into()).two_sided());
        let v = DVec3::new;
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let rectangle = |centre, axes| Geometry::Rectangle { to_world: placed(centre, axes) };
        let cube = |centre, axes| Geometry::Cube { to_world: placed(centre, axes) };
        let shapes = vec![
            shape("floor", rectangle(v(0.0, 0.0, 0.0), [z, x, y]), 0),
            shape("ceiling", rectangle(v(0.0, 2.0, 0.0), [x, z, -y]), 0),
            shape("back", rectangle(v(0.0, 1.0, -1.0), [x, y, z]), 0),
            shape("right", rectangle(v(1.0, 1.0, 0.0), [z, y, -x]), 2),
            shape("left", rectangle(v(-1.0, 1.0, 0.0), [y, z, x]), 1),
            shape(
                "short-block",
                cube(
                    v(0.328631, 0.3, 0.374592),
                    [v(0.0851643, 0.0, -0.284951), v(0.289542, 0.0, 0.0865363), v(0.0, -0.3, 0.0)],
                ),
                0,
            ),
            shape(
                "tall-block",
                cube(
                    v(-0.335439, 0.6, -0.291415),
                    [v(0.286776, 0.0, -0.0997984), v(0.098229, 0.0, 0.282266), v(0.0, -0.6, 0.0)],
                ),
                0,
            ),
            emitting(
                shape("light", rectangle(v(-0.005, 1.98, -0.03), [0.235 * x, 0.19 * z, -y]), 3),
                Rgb::new(17.0, 12.0, 4.0),
            ),
        ];
        let camera = Camera::look_at(v(0.0, 1.0, 6.8), v(0.0, 1.0, 0.0), y, 19.5);
        let mut scene = scene("cornell-bitterli", camera, materials.into(), shapes);
        (scene.film.width, scene.film.height, scene.film.filter) = (1024, 1024, Filter::TENT);
        // Its max_depth of 65 counts the ray to the light.
        scene.render = RenderSettings { samples: Some(64), bounces: Some(Some(64)), roulette_from: None };
        Ok(scene)
    },
};

#[cfg(test)]
mod tests {
    use super::super::builtin;
    use super::*;
    use glam::{DAffine3, DMat4};

    /// The corners of \[−1, 1\]² or \[−1, 1\]³ under the map.
    fn corners(to_world: DAffine3, cube: bool) -> Vec<DVec3> {
        let signs = [-1.0, 1.0];
        let thick: &[f64] = if cube { &signs } else { &[0.0] };
        let flat = signs.iter().flat_map(|&x| signs.iter().map(move |&y| (x, y)));
        flat.flat_map(|(x, y)| thick.iter().map(move |&z| to_world.transform_point3(DVec3::new(x, y, z)))).collect()
    }

    #[test]
    #[allow(clippy::print_stderr, reason = "a test that skips says so")]
    fn the_geometry_is_that_of_the_published_file() {
        let data = std::env::var("WHITEFURNACE_DATA").unwrap_or_else(|_| "../shared/data".into());
        let path = std::path::Path::new(&data).join("scenes/bitterli/cornell-box/mitsuba_v3.xml");
        let Ok(text) = std::fs::read_to_string(&path) else {
            eprintln!("skipped: no file {}", path.display());
            return;
        };
        let ours = builtin("cornell-bitterli", &[]).unwrap().unwrap();
        let published = text.split("<shape type=\"").skip(1);
        let mut compared = 0;
        for block in published {
            let field = |key: &str| block.split(key).nth(1).and_then(|rest| rest.split('"').next()).unwrap();
            let name = match field("id=\"") {
                "Floor" => "floor",
                "Ceiling" => "ceiling",
                "BackWall" => "back",
                "RightWall" => "right",
                "LeftWall" => "left",
                "ShortBox" => "short-block",
                "TallBox" => "tall-block",
                "Light" => "light",
                other => panic!("{other} is new"),
            };
            let numbers: Vec<f64> =
                field("matrix value=\"").split_whitespace().map(|number| number.parse().unwrap()).collect();
            let theirs = DAffine3::from_mat4(DMat4::from_cols_slice(&numbers).transpose());
            let shape = ours.shapes.iter().find(|shape| shape.name == name).unwrap();
            let (to_world, cube) = match shape.geometry {
                Geometry::Rectangle { to_world } => (to_world, false),
                Geometry::Cube { to_world } => (to_world, true),
                _ => panic!("{name}"),
            };
            let here = corners(to_world, cube);
            for p in corners(theirs, cube) {
                let gap = here.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
                // The file's zeros are rounded to 1e-7.
                assert!(gap < 5e-7, "{name}: {p} is {gap} off");
            }
            if name == "light" {
                assert!((theirs.matrix3.x_axis.cross(theirs.matrix3.y_axis).normalize() + DVec3::Y).length() < 1e-6);
                assert!(to_world.matrix3.x_axis.cross(to_world.matrix3.y_axis).y < 0.0);
            }
            compared += 1;
        }
        assert_eq!(compared, ours.shapes.len());
    }
}
