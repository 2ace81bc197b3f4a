//! Solutions of rooms that are known in closed form, by every solver; where the power goes; and what is no room.

use whitefurnace::glam::DVec3;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::radiosity::RadiosityError;
use whitefurnace::render::radiosity::factors::Visibility;
use whitefurnace::render::radiosity::model::Radiosity;
use whitefurnace::render::radiosity::patches::{Fineness, Materials};
use whitefurnace::render::radiosity::solve::{Method, Settings};
use whitefurnace::scene::builtin::builtin;
use whitefurnace::scene::{Geometry, Light, Material, Mesh, Scene, Shape};

use crate::common::{named, scene};
use crate::{limit, radiosity, solved};

fn cube(across: usize, rho: &str, bounces: Option<u32>) -> [f64; 3] {
    let scene = named("cube-one-emitter", &[&format!("rho={rho}")]);
    let method = if bounces.is_some() { Method::Jacobi } else { Method::GaussSeidel };
    let model = Radiosity {
        fineness: Fineness::Count(6 * across * across),
        factors: Box::new(Visibility { tolerance: 1e-9, ..Visibility::default() }),
        method,
        settings: Settings { bounces, ..Settings::default() },
        ..Radiosity::default()
    };
    let solved = model.solve(&scene).expect("a solution");
    assert_eq!(solved.patches.all().len(), 6 * across * across);
    ["bottom", "top", "left"].map(|name| radiosity(&solved, name).0.x)
}

/// Face means of an infinitely fine mesh, from three.
fn continuous(rho: &str, bounces: Option<u32>) -> [f64; 3] {
    let [coarse, middle, fine] = [5, 10, 20].map(|across| cube(across, rho, bounces));
    [0, 1, 2].map(|face| limit([coarse[face], middle[face], fine[face]]))
}

#[test]
fn the_cube_has_its_published_means_patch_by_patch_and_in_the_limit() {
    // Nine decimals are published.
    for (rho, across, means) in [
        ("0.5", 1, [1.090909098, 0.181745826, 0.181836269]),
        ("0.5", 4, [1.102645712, 0.171829422, 0.181381216]),
        ("0.5", 16, [1.104210821, 0.171255694, 0.181133371]),
        ("0.9", 1, [2.372881375, 1.525310551, 1.525452019]),
    ] {
        for (mean, expected) in cube(across, rho, None).iter().zip(means) {
            assert!((mean - expected).abs() < 2e-9, "rho {rho}, {across} across: {mean} against {expected}");
        }
    }
    for (bounces, means) in [
        (None, [1.104362, 0.171216, 0.181106]),
        (Some(2), [1.063938, 0.129263, 0.139200]),
        (Some(3), [1.082722, 0.151010, 0.160317]),
    ] {
        for (mean, expected) in continuous("0.5", bounces).iter().zip(means) {
            // Six decimals are published.
            assert!((mean - expected).abs() < 1e-5, "{bounces:?} reflections: {mean} against {expected}");
        }
    }
    // After one reflection means are half the view factors, at any fineness.
    for across in [1, 3] {
        let [bottom, top, side] = cube(across, "0.5", Some(1));
        assert!((bottom - 1.0).abs() < 1e-9 && (top - 0.0999124478).abs() < 1e-9 && (side - 0.1000218880).abs() < 1e-9);
    }
}

#[test]
fn spheres_have_their_closed_forms() {
    // Any closed surface of even albedo and emission: e / (1 − ρ), times π; and after r reflections.
    let furnace = named("furnace-sphere", &["rho=0.5/0.2/0.8", "e=0.5"]);
    let wall = radiosity(&solved(&furnace, 60), "wall").0 / std::f64::consts::PI;
    let exact = [1.0, 0.625, 2.5];
    assert!((0..3).all(|c| (wall[c] - exact[c]).abs() < 1e-9), "{wall}");
    for k in [0.3, 0.5_f64] {
        // B₁ = 1 / (1 − ρ₁ ρ₂ k² / (1 − ρ₂ (1 − k²))), B₂ = ρ₂ k² B₁ / (1 − ρ₂ (1 − k²)).
        let own = 1.0 - 0.7 * (1.0 - k * k);
        let inner = 1.0 / (1.0 - 0.3 * 0.7 * k * k / own);
        let outer = 0.7 * k * k * inner / own;
        // Published for k = ½, to eleven digits.
        assert!(k != 0.5 || (inner - 1.12426035503).abs() < 5e-12 && (outer - 0.414201183432).abs() < 5e-12);
        // Concentric: emission 1 on the inner one, albedos .3 and .7.
        let sphere = |name: &str, radius: f64, material: usize, inside_out: bool| Shape {
            name: name.into(),
            geometry: Geometry::Sphere { centre: DVec3::ZERO, radius },
            flip_normals: inside_out,
            material,
            emission: (!inside_out).then(|| Rgb::grey(std::f64::consts::FRAC_1_PI)),
        };
        let materials = [0.3, 0.7].map(|rho| Material::diffuse("grey", Rgb::grey(rho).into()));
        let shapes = vec![sphere("inner", k, 0, false), sphere("outer", 1.0, 1, true)];
        let solved = solved(&scene(materials.into(), shapes, Vec::new()), 300);
        // What a factor is wrong by, of 300 of them, gathered by chance and reflected at most 1 / (1 − .7) times.
        let error = 300.0_f64.sqrt() * solved.report.error_rms / 0.3;
        for (name, exact) in [("inner", inner), ("outer", outer)] {
            let found = radiosity(&solved, name).0.x;
            assert!(error < 0.02 && (found - exact).abs() < error, "{name}: {found} against {exact}, error {error}");
        }
    }
}

#[test]
fn all_solvers_find_one_solution() {
    let scene = named("cornell-original", &[]);
    let by = |method| {
        let settings = Settings { tolerance: 1e-12, ..Settings::default() };
        let model = Radiosity { fineness: Fineness::Count(200), method, settings, ..Radiosity::default() };
        model.solve(&scene).expect("a solution")
    };
    let dense = by(Method::Dense);
    let largest = dense.solved.radiosity.iter().map(|b| b.max_channel()).fold(0.0, f64::max);
    assert!(dense.solved.converged && largest > 10.0);
    for method in Method::ALL {
        let other = by(method);
        assert!(other.solved.converged, "{method}");
        for (a, b) in dense.solved.radiosity.iter().zip(&other.solved.radiosity) {
            assert!((a.0 - b.0).abs().max_element() < 1e-9 * largest, "{method}: {a} against {b}");
        }
        assert!(other.solved.certified_bound < 1e-9 * largest);
    }
}

#[test]
fn power_is_absorbed_or_leaves_by_the_open_front() {
    let open = solved(&named("cornell-original", &[]), 600);
    let energy = open.energy();
    let emitted = energy.emitted.0;
    // The exchanges are reciprocal, so that nothing but the solver's residual is missing.
    assert!(energy.imbalance().0.abs().max_element() < 1e-6 * emitted.max_element());
    // A black lid on the front takes up what escaped without it.
    let mut description = builtin("cornell-original", &[]).unwrap().unwrap();
    let corners = [(552.8, 0.0), (556.0, 548.8), (0.0, 548.8), (0.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let lid = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
    description.materials.push(Material::diffuse("black", Rgb::BLACK.into()));
    let material = description.materials.len() - 1;
    let geometry = Geometry::Mesh(lid.into());
    description.shapes.push(Shape { name: "front".into(), geometry, flip_normals: false, material, emission: None });
    let closed = solved(&Scene::new(description).expect("a scene"), 660);
    let front = closed.surfaces().into_iter().find(|surface| surface.name == "front").expect("the lid");
    let (out, caught) = (energy.escaped.0, front.irradiance.0 * front.area);
    // Rows of the open box are short by what they sum to too much or too little elsewhere: visibility, 1e-3 of a row. The two
    // meshes differ a little.
    assert!((out - caught).abs().max_element() < 5e-3 * emitted.max_element(), "{out} against {caught}");
    assert!((closed.energy().escaped.0 / emitted).abs().max_element() < 5e-3, "nothing leaves a closed box");
    assert!(out.x > 0.25 * emitted.x && out.x < 0.35 * emitted.x);
}

fn square(name: &str, flip: bool, material: usize) -> Shape {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
    Shape { name: name.into(), geometry: Geometry::Mesh(mesh.into()), flip_normals: flip, material, emission: None }
}

#[test]
fn bad_input_is_one_clear_error_or_a_correct_zero() {
    let grey = || Material::diffuse("grey", Rgb::grey(0.5).into());
    let refused = |scene: &Scene| Radiosity::default().solve(scene).unwrap_err();
    let white = Material::diffuse("snow", Rgb::WHITE.into());
    let error = refused(&scene(vec![white], vec![square("field", false, 0)], Vec::new()));
    assert!(matches!(&error, RadiosityError::TooReflective { material, .. } if material == "snow"), "{error}");
    let error = refused(&scene(vec![grey()], vec![square("a", false, 0), square("b", false, 0)], Vec::new()));
    assert!(matches!(&error, RadiosityError::Coincident { first, second } if first == "a" && second == "b"), "{error}");
    // Back to back they cover each other: nothing is left.
    let back_to_back = scene(vec![grey()], vec![square("a", false, 0), square("b", true, 0)], Vec::new());
    assert_eq!(refused(&back_to_back), RadiosityError::NoSurface);
    let point = Light::Point { position: DVec3::Z, intensity: Rgb::WHITE };
    assert_eq!(refused(&scene(vec![grey()], vec![square("a", false, 0)], vec![point])), RadiosityError::NotASurface);
    // A triangle without area, and one that is a point, have no share in anything.
    let mut lit = square("lamp", false, 0);
    lit.emission = Some(Rgb::WHITE);
    let corners = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
    let flat = Mesh::new(corners, vec![[0, 1, 2], [1, 1, 1]]).expect("a mesh");
    let degenerate = Shape { name: "line".into(), geometry: Geometry::Mesh(flat.into()), ..square("", false, 0) };
    let with = solved(&scene(vec![grey()], vec![lit.clone(), degenerate.clone()], Vec::new()), 16);
    assert_eq!(with.surfaces().len(), 1);
    assert_eq!(refused(&scene(vec![grey()], vec![degenerate], Vec::new())), RadiosityError::NoSurface);
    // Without light every radiosity is 0, and the equations say so exactly.
    let dark = solved(&scene(vec![grey()], vec![square("a", false, 0)], Vec::new()), 16);
    assert!(dark.solved.converged && dark.solved.radiosity.iter().all(|b| b.is_black()));
    // A room turned inside out sees nothing of itself.
    let mut description = builtin("furnace-box", &[]).unwrap().unwrap();
    description.shapes[0].flip_normals = false;
    let outside = solved(&Scene::new(description).expect("a scene"), 54);
    let energy = outside.energy();
    assert!((energy.emitted.0 - energy.escaped.0).abs().max_element() < 1e-9 && energy.absorbed.is_black());
    let gold = named("veach-mis", &[]);
    let error = refused(&gold);
    assert!(matches!(error, RadiosityError::NotDiffuse { .. }), "{error}");
    let approximated =
        Radiosity { materials: Materials::Approximated, fineness: Fineness::Count(100), ..Radiosity::default() };
    let solution = approximated.solve(&gold).expect("a solution");
    assert!(solution.energy().absorbed.max_channel() > 0.0);
}
