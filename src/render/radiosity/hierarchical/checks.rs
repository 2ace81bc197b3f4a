//! Hierarchical against dense solutions on the same elements, against closed forms, and the growth of the number of links.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::growth::{Growth, Size};
use super::model::{Hierarchical, HierarchicalSolution, Statistics};
use super::network::Light;
use super::tree::Tree;
use crate::math::color::Rgb;
use crate::render::radiosity::factors::{self, MEMORY, Visibility};
use crate::render::radiosity::patches::{Fineness, Materials};
use crate::render::radiosity::solve::{Method, Settings};
use crate::render::radiosity::system::System;
use crate::scene::builtin::builtin;
use crate::scene::{Geometry, Material, Mesh, Scene, Shape};

fn scene(name: &str, params: &[(&str, &str)]) -> Scene {
    let params: Vec<(String, String)> = params.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
    Scene::new(builtin(name, &params).unwrap().unwrap()).unwrap()
}

fn model(finest: usize, error: f64) -> Hierarchical {
    Hierarchical { fineness: Fineness::Count(finest), error, ..Hierarchical::default() }
}

/// The light of elements by a matrix of all view factors between them.
fn dense(scene: &Scene, tree: &Tree, ends: &[usize], seed: u64) -> Vec<Rgb> {
    let patches = tree.patches(scene, ends).unwrap();
    let method = Visibility { seed, ..Visibility::default() };
    let (matrix, ..) = factors::find(&method, scene, &patches, None, MEMORY).unwrap();
    let each = |of: fn(&super::tree::Node) -> Rgb| ends.iter().map(|&i| of(&tree.nodes[i])).collect();
    let areas = ends.iter().map(|&i| tree.nodes[i].area).collect();
    let system = System::new(matrix, areas, each(|node| node.reflectance), each(|node| node.emission)).unwrap();
    Method::GaussSeidel.solve(&system, Settings::default()).unwrap().radiosity
}

/// Root of the sum of squares, by area.
fn root(tree: &Tree, values: impl Iterator<Item = (usize, Rgb)>) -> f64 {
    values.map(|(i, value)| tree.nodes[i].area * value.0.length_squared()).sum::<f64>().sqrt()
}

/// Mean radiosity of the shapes of a solution, one channel, by area.
fn means(found: &HierarchicalSolution) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; found.patches.shapes().len()];
    for (patch, b) in found.patches.all().iter().zip(&found.solved.radiosity) {
        sums[patch.shape][0] += patch.area * b.0.x;
        sums[patch.shape][1] += patch.area;
    }
    sums.iter().map(|[b, area]| b / area).collect()
}

/// Holds solutions against matrices on the same elements.
fn assert_errors_are_kept(scene: &Scene, finest: usize, most_roots: usize, errors: &[f64]) {
    let name = scene.name();
    let tree = Tree::new(scene, Fineness::Count(finest), Materials::Diffuse, most_roots).unwrap();
    let ends = tree.ends(|_| true);
    let reflected = |b: &[Rgb]| root(&tree, ends.iter().zip(b).map(|(&i, &b)| (i, b - tree.nodes[i].emission)));
    // A matrix has the errors of its rays: the mean of two has half the difference.
    let [one, two] = [11, 12].map(|seed| dense(scene, &tree, &ends, seed));
    let exact: Vec<Rgb> = one.iter().zip(&two).map(|(&a, &b)| (a + b) * 0.5).collect();
    let gaps = one.iter().zip(&two).map(|(&a, &b)| (a - b) * 0.5);
    let own = root(&tree, ends.iter().copied().zip(gaps)) / reflected(&exact);
    let distance = |light: &Light| {
        let gaps = ends.iter().zip(&exact).map(|(&i, &b)| (i, light.b[i] - b));
        root(&tree, gaps) / reflected(&exact)
    };
    for &error in errors {
        let (found, light) = model(finest, error).solve_tree(scene, &tree, 0.0).unwrap();
        let Statistics { estimated_error, .. } = found.statistics;
        let measured = distance(&light);
        assert!(measured <= error.hypot(own), "{name}: {measured} for {error}, {:?}", found.statistics);
        assert!(measured >= 0.1 * error, "{name}: {measured} for {error} is more than was asked for");
        assert!(found.solved.converged && estimated_error <= error);
        // Its twin, whose faces reflect a fifth more, is seen.
        let mut twin = light;
        for (b, node) in twin.b.iter_mut().zip(&tree.nodes) {
            *b = node.emission + (*b - node.emission) * 1.2;
        }
        assert!(distance(&twin) > error.hypot(own), "{name}: a twin is not seen at {error}");
    }
}

#[test]
fn the_error_asked_for_is_kept_against_the_matrix_on_the_same_elements() {
    for (name, finest) in [("cornell-original", 1200), ("cube-one-emitter", 600), ("cornell-bitterli", 1200)] {
        assert_errors_are_kept(&scene(name, &[]), finest, 100, &[0.1, 0.03, 0.01]);
    }
    // Where a matrix of rays is no judge for it.
    assert_errors_are_kept(&scene("cube-one-emitter", &[]), 600, 100, &[0.003, 0.001]);
}

#[test]
fn the_error_asked_for_is_kept_with_clusters() {
    assert_errors_are_kept(&scene("cornell-original", &[]), 1200, 1, &[0.1, 0.03, 0.01]);
    assert_errors_are_kept(&scene("cornell-bitterli", &[]), 1200, 1, &[0.1, 0.03, 0.01]);
    assert_errors_are_kept(&hills(9), 800, 100, &[0.1, 0.03, 0.01]);
}

/// The cube with one side that emits, and in it a sheet of 2 m² triangles.
fn hills(m: u32) -> Scene {
    let mut description = builtin("cube-one-emitter", &[]).unwrap().unwrap();
    let at = |k: u32| f64::from(k) / f64::from(m);
    let height = |x: f64, y: f64| 0.5 + 0.1 * (7.0 * x).sin() * (5.0 * y).cos();
    let corners = (0..=m).flat_map(|j| (0..=m).map(move |i| (at(i), at(j))));
    let positions = corners.map(|(x, y)| DVec3::new(0.1 + 0.8 * x, 0.1 + 0.8 * y, height(x, y))).collect();
    let triangles = (0..m * m).flat_map(|k| {
        let a = k / m * (m + 1) + k % m;
        [[a, a + 1, a + m + 2], [a, a + m + 2, a + m + 1]]
    });
    let mesh = Mesh::new(positions, triangles.collect()).unwrap();
    description.materials.push(Material::diffuse("hills", Rgb::new(0.7, 0.5, 0.3).into()).two_sided());
    description.shapes.push(Shape {
        name: "hills".into(),
        geometry: Geometry::Mesh(Arc::new(mesh)),
        material: description.materials.len() - 1,
        emission: None,
        ..description.shapes[0].clone()
    });
    Scene::new(description).unwrap()
}

#[test]
fn a_lamp_behind_a_slit_is_not_missed() {
    // A sphere that shines through a hole of .2 by .2, of which most links see nothing at first.
    let mut description = builtin("cube-one-emitter", &[]).unwrap().unwrap();
    let plate = |x: [f64; 2], y: [f64; 2], z: f64| Geometry::Rectangle {
        to_world: DAffine3::from_scale_rotation_translation(
            0.5 * DVec3::new(x[1] - x[0], y[1] - y[0], 2.0),
            glam::DQuat::IDENTITY,
            DVec3::new(f64::midpoint(x[0], x[1]), f64::midpoint(y[0], y[1]), z),
        ),
    };
    let (floor, lamp) = (description.shapes[1].clone(), description.shapes[0].clone());
    let black = description.materials.len();
    description.materials.push(Material::diffuse("black", Rgb::BLACK.into()).two_sided());
    let screen = [
        ([-3.0, 3.0], [0.1, 3.0]),
        ([-3.0, 3.0], [-3.0, -0.1]),
        ([0.1, 3.0], [-0.1, 0.1]),
        ([-3.0, -0.1], [-0.1, 0.1]),
    ];
    let mut shapes = vec![
        Shape {
            name: "floor".into(),
            geometry: plate([-1.0, 1.0], [-1.0, 1.0], 0.0),
            flip_normals: false,
            ..floor.clone()
        },
        Shape {
            name: "lamp".into(),
            geometry: Geometry::Sphere { centre: DVec3::new(0.0, 0.0, 2.0), radius: 0.5 },
            flip_normals: false,
            ..lamp
        },
    ];
    shapes.extend(screen.map(|(x, y)| Shape {
        name: "screen".into(),
        geometry: plate(x, y, 1.0),
        material: black,
        flip_normals: false,
        ..floor.clone()
    }));
    description.shapes = shapes;
    let scene = Scene::new(description).unwrap();
    let light = |error: f64, seed: u64| {
        let found = Hierarchical { seed, ..model(800, error) }.solve(&scene).unwrap();
        assert!(found.statistics.estimated_error <= error, "{:?}", found.statistics);
        found.surfaces().into_iter().find(|surface| surface.name == "floor").unwrap().irradiance.0.x
    };
    // By a rule of midpoints over hole and lamp: each point of the floor sees of the sphere what is in the hole's projection.
    let exact = through_the_hole();
    for seed in [1, 2, 3] {
        let found = light(0.03, seed);
        assert!((found / exact - 1.0).abs() < 0.06, "{found} against {exact}, seed {seed}");
    }
}

/// Mean irradiance of [−1, 1]² at z = 0 from a sphere of radiosity 1 about (0, 0, 2), radius ½, through [−.1, .1]² at z = 1: by the
/// rule of midpoints over floor and hole, where each ray either meets the sphere or does not.
fn through_the_hole() -> f64 {
    let n = 60;
    let at = |k: usize, half: f64| half * ((2 * k + 1) as f64 / n as f64 - 1.0);
    let mut sum = 0.0;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let p = DVec3::new(at(i, 1.0), at(j, 1.0), 0.0);
        for (k, l) in (0..n).flat_map(|k| (0..n).map(move |l| (k, l))) {
            let way = DVec3::new(at(k, 0.1), at(l, 0.1), 1.0) - p;
            let (d, to) = (way.normalize(), DVec3::new(0.0, 0.0, 2.0) - p);
            if to.length_squared() - to.dot(d).powi(2) < 0.25 {
                // cos² / (π r²) of the area of the hole.
                sum += d.z * d.z / (std::f64::consts::PI * way.length_squared()) * 0.04;
            }
        }
    }
    sum / (n as f64).powi(4)
}

#[test]
fn links_grow_with_the_number_of_polygons() {
    let points: Vec<Size> = [8, 16, 24]
        .iter()
        .map(|&m| {
            let fineness = Fineness::Area((0.8 / f64::from(m)).powi(2));
            let found = Hierarchical { fineness, ..model(1, 0.03) }.solve(&hills(m)).unwrap().statistics;
            Size { finest: found.finest, leaves: found.leaves, links: found.links }
        })
        .collect();
    // The error, and the size of the elements to that of the polygons, are held fixed. n log n has 1.13 here.
    let growth = Growth { error: 0.03, points };
    assert!(growth.exponent().unwrap()[0] < 1.2, "{growth:?}");
}

#[test]
fn the_cube_has_the_means_of_the_continuous_solution() {
    let found = model(6 * 32 * 32, 0.002).solve(&scene("cube-one-emitter", &[])).unwrap();
    let means = means(&found);
    // Bottom, top and a side; 0.2 % of the root mean square, 0.48, and what is left by elements of 1/32.
    for exact in [1.104362, 0.171216, 0.181106] {
        assert!(means.iter().any(|mean| (mean - exact).abs() < 1.5e-3), "{exact} in {means:?}");
    }
    // Nothing is lost in a closed room but what is rounded off by links that are not reciprocal.
    let energy = found.energy;
    let gap = energy.imbalance().0.abs().max_element();
    assert!(gap < 0.004, "{energy:?}");
    assert!(energy.unsolved.0.abs().max_element() < 1e-9, "{energy:?}");
    // With few reflections it is what the next one would add.
    let one = Hierarchical { bounces: Some(1), ..model(600, 0.01) }.solve(&scene("cube-one-emitter", &[])).unwrap();
    assert!(one.energy.unsolved.0.x > 0.1, "{:?}", one.energy);
}

#[test]
fn a_sphere_that_sees_itself_has_the_light_of_the_furnace() {
    let scene = scene("furnace-sphere", &[]);
    let found = model(300, 0.01).solve(&scene).unwrap();
    let emission = found.patches.all()[0].emission;
    let rho = found.patches.all()[0].reflectance;
    let exact = emission / (Rgb::WHITE - rho);
    for b in &found.solved.radiosity {
        assert!((*b - exact).0.abs().max_element() < 0.01 * exact.max_channel(), "{b} against {exact}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = scene("cornell-original", &[]);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| model(400, 0.05).solve(&scene).unwrap())
    };
    let one = run(1);
    for threads in [2, 3] {
        let other = run(threads);
        assert_eq!(one.solved.radiosity, other.solved.radiosity, "{threads} threads");
        assert_eq!(one.statistics.links, other.statistics.links);
        assert_eq!(one.statistics.rays, other.statistics.rays);
    }
    assert_ne!(
        one.solved.radiosity,
        Hierarchical { seed: 2, ..model(400, 0.05) }.solve(&scene).unwrap().solved.radiosity
    );
}

#[test]
fn what_cannot_be_asked_for_is_said() {
    let scene = scene("cube-one-emitter", &[]);
    for error in [0.0, 1.0, f64::NAN] {
        let refused = model(10, error).solve(&scene).unwrap_err().to_string();
        assert!(refused.contains("above 0 and below 1"), "{refused}");
    }
    let refused = Hierarchical { tolerance: 0.0, ..model(10, 0.1) }.solve(&scene).unwrap_err().to_string();
    assert!(refused.contains("tolerance"), "{refused}");
    assert!(model(0, 0.1).solve(&scene).is_err());
}
