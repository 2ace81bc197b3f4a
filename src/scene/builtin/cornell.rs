//! The Cornell box as it was measured, and as Mitsuba ships it.
//!
//! Both have the measured geometry, in millimetres: x to the left as the camera sees it, y up, z away. The front, z = 0,
//! is open. The box is not exact: the red wall leans and is not planar, and is cut along the diagonal from its lower
//! front corner. The blocks have no bottom.
//! # References
//! - Goral, Torrance, Greenberg & Battaile 1984, Modeling the interaction of light between diffuse surfaces, SIGGRAPH
//! - Cornell University Program of Computer Graphics, Cornell box data (geometry, reflectances, light)

use glam::DVec3;

use super::Builtin;
use super::parts::{emitting, faces, scene, shape};
use crate::math::color::Rgb;
use crate::scene::{Camera, Geometry, Material, RenderSettings, Shape};

const HEIGHT: f64 = 548.8;
const DEPTH: f64 = 559.2;

/// Reflectances of the measured spectra under D65 as linear Rec.709, CIE 1931 2°, constant beyond 400 to 700 nm.
const WHITE: Rgb = Rgb::new(0.738259, 0.735978, 0.738681);
const GREEN: Rgb = Rgb::new(0.068418, 0.398456, 0.086567);
const RED: Rgb = Rgb::new(0.493887, 0.048868, 0.051164);
/// The measured emission (0, 8, 15.6, 18.4 at 400, 500, 600, 700 nm) as linear Rec.709, where an equal-energy spectrum of
/// 1 has luminance 1: its own unit and its own colour, not adapted to the reflectances' white.
const EMISSION: Rgb = Rgb::new(20.790691, 10.846524, 2.770253);
/// Of the light's own surface, flat over the spectrum.
const LIGHT_REFLECTANCE: Rgb = Rgb::grey(0.78);

pub(super) const ORIGINAL: Builtin = Builtin {
    name: "cornell-original",
    summary: "the measured Cornell box: D65 colours of the measured spectra, one-sided light in the ceiling's plane",
    params: &[],
    closed_form: Some(
        "direct light: (278, 400, 559.2) on the back wall receives .0564689832 L, the tall block's top centre .169954967 L",
    ),
    build: |_| {
        let materials = [("white", WHITE), ("green", GREEN), ("red", RED), ("light", LIGHT_REFLECTANCE)];
        let ceiling = faces(&ceiling_around_the_light());
        let shapes = surfaces(ceiling, HEIGHT, EMISSION, 0);
        Ok(scene("cornell-original", camera(), diffuse(&materials), shapes))
    },
};

pub(super) const MITSUBA: Builtin = Builtin {
    name: "cornell-mitsuba",
    summary: "the measured box in the colours of Mitsuba's cbox-rgb: not adapted to white, the light .5 lower, bluish blocks",
    params: &[],
    closed_form: Some(
        "direct light: (278, 400, 559.2) on the back wall receives .0564534009 L, the tall block's top centre .170406720 L",
    ),
    build: |_| {
        let materials = [
            ("white", Rgb::new(0.885809, 0.698859, 0.666422)),
            ("green", Rgb::new(0.105421, 0.37798, 0.076425)),
            ("red", Rgb::new(0.570068, 0.0430135, 0.0443706)),
            ("light", Rgb::new(0.936461, 0.740433, 0.705267)),
            ("box", Rgb::new(0.45, 0.30, 0.90)),
        ];
        let [a, b, c, d] = CEILING.map(|(x, z)| DVec3::new(x, HEIGHT, z));
        let shapes = surfaces(faces(&[[a, b, c, d]]), HEIGHT - 0.5, Rgb::new(18.387, 10.9873, 2.75357), 4);
        let mut scene = scene("cornell-mitsuba", camera(), diffuse(&materials), shapes);
        (scene.film.width, scene.film.height) = (256, 256);
        // Its max_depth of 6 counts the ray to the light.
        scene.render = RenderSettings { samples: Some(256), bounces: Some(Some(5)), roulette_from: None };
        Ok(scene)
    },
};

fn camera() -> Camera {
    let eye = DVec3::new(278.0, 273.0, -800.0);
    // A film of .025 behind a focal length of .035.
    let angle = 2.0 * (0.0125_f64 / 0.035).atan();
    Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, angle.to_degrees())
}

fn diffuse(materials: &[(&str, Rgb)]) -> Vec<Material> {
    materials.iter().map(|&(name, rho)| Material::diffuse(name, rho.into())).collect()
}

/// Corners (x, z), counter-clockwise seen from below.
const CEILING: [(f64, f64); 4] = [(556.0, 0.0), (556.0, DEPTH), (0.0, DEPTH), (0.0, 0.0)];
const LIGHT: [(f64, f64); 4] = [(343.0, 227.0), (343.0, 332.0), (213.0, 332.0), (213.0, 227.0)];
/// Corners (x, z) of the tops, counter-clockwise seen from above.
const SHORT_BLOCK: [(f64, f64); 4] = [(130.0, 65.0), (82.0, 225.0), (240.0, 272.0), (290.0, 114.0)];
const TALL_BLOCK: [(f64, f64); 4] = [(423.0, 247.0), (265.0, 296.0), (314.0, 456.0), (472.0, 406.0)];

/// The ceiling without the light's place, so that no two surfaces coincide.
fn ceiling_around_the_light() -> [[DVec3; 4]; 4] {
    let (outer, inner) = (CEILING.map(overhead), LIGHT.map(overhead));
    std::array::from_fn(|i| {
        let next = (i + 1) % 4;
        [outer[i], outer[next], inner[next], inner[i]]
    })
}

fn overhead((x, z): (f64, f64)) -> DVec3 {
    DVec3::new(x, HEIGHT, z)
}

/// The top and the four sides.
fn block(top: [(f64, f64); 4], height: f64) -> Geometry {
    let at = |i: usize, y: f64| DVec3::new(top[i % 4].0, y, top[i % 4].1);
    let side = |i: usize| [at(i + 1, 0.0), at(i + 1, height), at(i, height), at(i, 0.0)];
    faces(&[[0, 1, 2, 3].map(|i| at(i, height)), side(0), side(1), side(2), side(3)])
}

fn surfaces(ceiling: Geometry, light_height: f64, emission: Rgb, block_material: usize) -> Vec<Shape> {
    let v = DVec3::new;
    let floor = [v(552.8, 0.0, 0.0), v(0.0, 0.0, 0.0), v(0.0, 0.0, DEPTH), v(549.6, 0.0, DEPTH)];
    let back = [v(549.6, 0.0, DEPTH), v(0.0, 0.0, DEPTH), v(0.0, HEIGHT, DEPTH), v(556.0, HEIGHT, DEPTH)];
    let green = [v(0.0, 0.0, DEPTH), v(0.0, 0.0, 0.0), v(0.0, HEIGHT, 0.0), v(0.0, HEIGHT, DEPTH)];
    let red = [v(552.8, 0.0, 0.0), v(549.6, 0.0, DEPTH), v(556.0, HEIGHT, DEPTH), v(556.0, HEIGHT, 0.0)];
    let light = LIGHT.map(|(x, z)| v(x, light_height, z));
    vec![
        shape("floor", faces(&[floor]), 0),
        shape("ceiling", ceiling, 0),
        emitting(shape("light", faces(&[light]), 3), emission),
        shape("back", faces(&[back]), 0),
        shape("green", faces(&[green]), 1),
        shape("red", faces(&[red]), 2),
        shape("short-block", block(SHORT_BLOCK, 165.0), block_material),
        shape("tall-block", block(TALL_BLOCK, 330.0), block_material),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::builtin;
    use super::*;
    use crate::scene::{Mesh, SceneDescription};

    fn mesh<'a>(scene: &'a SceneDescription, name: &str) -> &'a Mesh {
        let shape = scene.shapes.iter().find(|shape| shape.name == name).expect("a shape of this name");
        let Geometry::Mesh(mesh) = &shape.geometry else { panic!("{name} is no mesh") };
        mesh
    }

    /// Sum of the triangles' areas times their normals, and of their areas.
    fn areas(mesh: &Mesh) -> (DVec3, f64) {
        let halves = mesh.triangles().iter().map(|corners| {
            let [a, b, c] = corners.map(|i| mesh.positions()[i as usize]);
            0.5 * (b - a).cross(c - a)
        });
        halves.fold((DVec3::ZERO, 0.0), |(sum, area), half| (sum + half, area + half.length()))
    }

    #[test]
    fn the_surfaces_have_the_published_areas_and_face_inwards() {
        let scene = builtin("cornell-original", &[]).unwrap().unwrap();
        for (name, area, facing) in [
            ("light", 13650.0, DVec3::NEG_Y),
            ("floor", 308_231.04, DVec3::Y),
            ("ceiling", 310_915.2 - 13650.0, DVec3::NEG_Y),
            ("back", 303_376.64, DVec3::NEG_Z),
            ("green", 306_888.96, DVec3::X),
            ("red", 306_904.514, DVec3::NEG_X),
        ] {
            let (sum, found) = areas(mesh(&scene, name));
            // The list has three decimals.
            assert!((found - area).abs() < 5e-4, "{name}: {found} against {area}");
            assert!(sum.dot(facing) > 0.999 * found, "{name} faces {sum}");
        }
    }

    #[test]
    fn the_walls_close_up_to_the_open_front() {
        // Over a closed surface the sum of area times normal is 0; what is missing is the front.
        let scene = builtin("cornell-original", &[]).unwrap().unwrap();
        let walls = ["floor", "ceiling", "light", "back", "green", "red"];
        let missing = -walls.iter().map(|name| areas(mesh(&scene, name)).0).sum::<DVec3>();
        // Rounding of sums near 3e5.
        assert!((missing - DVec3::new(0.0, 0.0, 304_254.72)).length() < 1e-8, "{missing}");
        for (name, height) in [("short-block", 165.0), ("tall-block", 330.0)] {
            // A block without its bottom misses the area of its top, upwards.
            let (sum, _) = areas(mesh(&scene, name));
            assert!(sum.x.abs() + sum.z.abs() < 1e-8 && sum.y > 2e4, "{name}: {sum}");
            assert!(mesh(&scene, name).positions().iter().all(|p| p.y == 0.0 || p.y == height));
        }
    }

    fn column(path: &std::path::Path, column: usize) -> Vec<(f64, f64)> {
        let text = std::fs::read_to_string(path).unwrap();
        let row = |line: &str| {
            let cells: Vec<f64> = line.split(',').filter_map(|cell| cell.trim().parse().ok()).collect();
            Some((*cells.first()?, *cells.get(column)?))
        };
        text.lines().filter_map(row).collect()
    }

    fn at(table: &[(f64, f64)], x: f64) -> f64 {
        let next = table.partition_point(|row| row.0 < x).clamp(1, table.len() - 1);
        let ((x0, y0), (x1, y1)) = (table[next - 1], table[next]);
        y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0)
    }

    #[test]
    #[allow(clippy::print_stderr, reason = "a test that skips says so")]
    fn the_colours_are_those_of_the_measured_spectra() {
        let data = std::env::var("WHITEFURNACE_DATA").unwrap_or_else(|_| "../shared/data".into());
        let folder = std::path::Path::new(&data).join("spectra");
        if !folder.join("cornell_box_reflectance.csv").exists() {
            eprintln!("skipped: no spectra at {}", folder.display());
            return;
        }
        let observer = |i| column(&folder.join("cie1931_2deg_1nm.csv"), i);
        let observer = [observer(1), observer(2), observer(3)];
        let d65 = column(&folder.join("CIE_Illum_D6500.csv"), 1);
        // IEC 61966-2-1 from the primaries and the white point, to seven digits.
        let to_rgb = glam::DMat3::from_cols_array(&[
            3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252,
        ]);
        let seen = |spectrum: &[(f64, f64)], illuminant: &dyn Fn(f64) -> f64| {
            let (mut xyz, mut white) = (DVec3::ZERO, 0.0);
            for (i, &(nm, y)) in observer[1].iter().enumerate() {
                let light = illuminant(nm);
                xyz += DVec3::new(observer[0][i].1, y, observer[2][i].1) * light * at(spectrum, nm);
                white += y * light;
            }
            to_rgb * (xyz / white)
        };
        for (number, ours) in [(1, WHITE), (2, GREEN), (3, RED)] {
            let spectrum = column(&folder.join("cornell_box_reflectance.csv"), number);
            let rgb = seen(&spectrum, &|nm| at(&d65, nm));
            // Six decimals of ours, seven digits of the matrix.
            assert!((rgb - ours.0).abs().max_element() < 2e-6, "{rgb} against {ours}");
        }
        let emission = [(400.0, 0.0), (500.0, 8.0), (600.0, 15.6), (700.0, 18.4)];
        let rgb = seen(&emission, &|_| 1.0);
        assert!((rgb - EMISSION.0).abs().max_element() < 2e-6, "{rgb} against {EMISSION}");
    }
}
