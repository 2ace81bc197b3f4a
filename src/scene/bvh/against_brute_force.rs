//! The tree against every triangle one by one, and against a test of another kind.

use glam::DVec3;
use proptest::prelude::*;
use rayon::prelude::*;

use super::exact::{TriangleHit, hit};
use super::kernel::Level;
use super::query::{Straight, Twist};
use super::triangles::TriangleBvh;
use crate::sampling::stream::{Stream, stream, uniform};
use crate::scene::ray::{NO_TRIANGLE, Ray, offset_origin_within};

struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    fn soup(triangles: Vec<[DVec3; 3]>) -> Self {
        let indices = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        Self { triangles: indices.collect(), positions: triangles.into_iter().flatten().collect() }
    }

    fn vertices(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|index| self.positions[index as usize])
    }

    /// The nearest of all hits of the f64 test.
    fn closest(&self, ray: &Ray) -> Option<TriangleHit> {
        let every = (0..self.triangles.len()).filter_map(|at| {
            let v = self.vertices(at);
            let flat = (v[1] - v[0]).cross(v[2] - v[0]) == DVec3::ZERO;
            if flat { None } else { hit(ray, v, at as u32) }
        });
        every.reduce(|best, hit| if hit.before(&best) { hit } else { best })
    }

    fn trees(&self) -> Vec<TriangleBvh> {
        let levels = Level::all().into_iter().flatten();
        levels.map(|level| TriangleBvh::build_at(level, &self.positions, &self.triangles)).collect()
    }
}

struct Dice(Stream);

impl Dice {
    fn new(seed: u64) -> Self {
        Self(stream(seed, 0, 0))
    }

    fn number(&mut self) -> f64 {
        uniform(&mut self.0)
    }

    fn point(&mut self) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| 2.0 * self.number() - 1.0))
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.number() * n as f64) as usize).min(n - 1)
    }
}

/// The twelve triangles of a box.
fn cuboid(min: DVec3, max: DVec3) -> Vec<[DVec3; 3]> {
    let mut all = Vec::new();
    for axis in 0..3 {
        for (from, along) in [(min, max - min), (max, min - max)] {
            let edge = |k: usize| {
                let mut e = DVec3::ZERO;
                e[(axis + k) % 3] = along[(axis + k) % 3];
                e
            };
            let corner = [from, from + edge(1), from + edge(1) + edge(2), from + edge(2)];
            all.extend([[corner[0], corner[1], corner[2]], [corner[0], corner[2], corner[3]]]);
        }
    }
    all
}

/// A room with two boxes, one of them thin as a sheet: 36 triangles, all along the axes.
fn room() -> Mesh {
    let mut all = cuboid(DVec3::ZERO, DVec3::splat(5.5));
    all.extend(cuboid(DVec3::new(1.0, 0.0, 1.0), DVec3::new(2.5, 1.5, 2.5)));
    all.extend(cuboid(DVec3::new(3.0, 0.0, 3.0), DVec3::new(4.0, 3.0, 3.0)));
    Mesh::soup(all)
}

fn meshes() -> Vec<(&'static str, Mesh)> {
    let mut dice = Dice::new(11);
    let mut soup = |count: usize, size: f64| {
        let triangles = (0..count).map(|_| {
            let at = dice.point();
            [at + size * dice.point(), at + size * dice.point(), at + size * dice.point()]
        });
        triangles.collect::<Vec<_>>()
    };
    let (small, large) = (soup(3000, 0.05), soup(200, 1.0));
    let sliver = |v: &[DVec3; 3]| [v[0], v[1], v[1] + 1e-9 * (v[2] - v[0])];
    let flat = |v: &[DVec3; 3]| v.map(|v| DVec3::new(v.x, v.y, 0.25));
    let far = |v: &[DVec3; 3]| v.map(|v| v + DVec3::new(1e6, -1e6, 1e6));
    let mut twice = small[..500].to_vec();
    twice.extend_from_slice(&small[..500]);
    let degenerate = large.iter().enumerate().map(|(i, v)| match i % 4 {
        0 => [v[0]; 3],
        1 => [v[0], v[1], v[0]],
        2 => [v[0], DVec3::NAN, v[2]],
        _ => *v,
    });
    let scaled = |scale: f64| Mesh::soup(small.iter().map(|v| v.map(|v| scale * v)).collect());
    vec![
        ("nothing", Mesh::soup(Vec::new())),
        ("one", Mesh::soup(large[..1].to_vec())),
        ("nine", Mesh::soup(large[..9].to_vec())),
        ("sixty", Mesh::soup(large[..60].to_vec())),
        ("small", Mesh::soup(small.clone())),
        ("large", Mesh::soup(large.clone())),
        ("slivers", Mesh::soup(large.iter().map(sliver).collect())),
        ("coplanar", Mesh::soup(small.iter().map(flat).collect())),
        ("far", Mesh::soup(small.iter().map(far).collect())),
        ("twice", Mesh::soup(twice)),
        ("hundredfold", Mesh::soup((0..300).map(|i| large[i % 3]).collect())),
        ("degenerate", Mesh::soup(degenerate.collect())),
        ("huge", scaled(1e120)),
        ("tiny", scaled(1e-60)),
        ("room", room()),
        ("sphere", icosphere(3)),
    ]
}

/// Rays of all kinds for a mesh: at random, along axes, at vertices, along edges, from surfaces, from far away.
fn ray_for(mesh: &Mesh, dice: &mut Dice) -> Ray {
    let v = if mesh.triangles.is_empty() {
        [DVec3::ZERO, DVec3::X, DVec3::Y]
    } else {
        mesh.vertices(dice.below(mesh.triangles.len()))
    };
    let v = if v.iter().all(|v| v.is_finite()) { v } else { [DVec3::ZERO, DVec3::X, DVec3::Y] };
    let size = v[0].distance(v[1]).max(v[0].distance(v[2])).max(f64::MIN_POSITIVE);
    let from = v[0] + size * 20.0 * dice.number().powi(3) * dice.point();
    let (b1, b2) = (dice.number(), dice.number());
    let inside = v[0] + 0.5 * b1 * (v[1] - v[0]) + 0.5 * b2 * (v[2] - v[0]);
    let axis = DVec3::AXES[dice.below(3)] * if dice.number() < 0.5 { 1.0 } else { -1.0 };
    let (origin, towards) = match dice.below(9) {
        0 => (from, dice.point()),
        1 => (from, inside - from),
        2 => (from, v[2] - from),
        3 => (from, v[0] + b1 * (v[1] - v[0]) - from),
        4 => (inside, dice.point()),
        5 => (v[1] - 3.0 * size * axis, axis),
        6 => (inside - 3.0 * size * axis, axis),
        7 => (v[0] - (v[1] - v[0]), v[1] - v[0]),
        _ => (inside + 1e4 * size * (inside - from), from - inside),
    };
    let dir = if towards.length() > 0.0 { towards.normalize() } else { DVec3::Z };
    let t_max = match dice.below(4) {
        0 => 5.0 * size * dice.number(),
        1 => origin.distance(inside),
        _ => f64::INFINITY,
    };
    Ray::up_to(origin, if dir.is_finite() { dir } else { DVec3::Z }, t_max)
}

/// How many of the rays are answered otherwise than by brute force, at any level.
fn disagreements<T: Twist>(mesh: &Mesh, rays: u64) -> usize {
    let trees = mesh.trees();
    let wrong = (0..rays).into_par_iter().filter(|&seed| {
        let ray = ray_for(mesh, &mut Dice::new(seed));
        let expected = mesh.closest(&ray);
        trees.iter().any(|tree| {
            let (found, occluded) = (tree.closest_with::<T>(&ray), tree.occluded_with::<T>(&ray));
            found != expected || occluded != expected.is_some()
        })
    });
    wrong.count()
}

/// The same of rays in bundles: of those that go nearly the same way, and of those that do not.
fn disagreements_of_bundles<T: Twist>(mesh: &Mesh, bundles: u64) -> usize {
    let trees = mesh.trees();
    let wrong = (0..bundles).into_par_iter().map(|seed| {
        let mut dice = Dice::new(seed);
        let first = ray_for(mesh, &mut dice);
        // From hardly apart to all around, some from elsewhere and a few of any kind; now and then one of another length.
        let spread = 10_f64.powf(-6.0 * dice.number());
        let rays: Vec<Ray> = (0..50)
            .map(|i| match dice.below(8) {
                0 if seed % 2 == 0 => ray_for(mesh, &mut dice),
                1 => Ray { origin: first.origin + spread * dice.point(), ..first },
                _ => {
                    let towards = first.dir + spread * dice.point();
                    let length = if i == 40 && seed % 16 == 0 { 3.0 } else { 1.0 };
                    Ray { dir: length * towards.try_normalize().unwrap_or(DVec3::X), ..first }
                }
            })
            .collect();
        let wrong = |tree: &TriangleBvh| {
            let mut hits = vec![None; rays.len()];
            tree.closest_of_each_with::<T>(&rays, &mut hits);
            // Brute force knows only rays of length 1; what the tree finds for the others alone is tested elsewhere.
            let expected = |ray: &Ray| {
                if ray.dir.length() < 2.0 { mesh.closest(ray) } else { tree.closest_with::<T>(ray) }
            };
            rays.iter().zip(&hits).filter(|(ray, hit)| **hit != expected(ray)).count()
        };
        trees.iter().map(wrong).sum::<usize>()
    });
    wrong.sum()
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    for (name, mesh) in meshes() {
        assert_eq!(disagreements::<Straight>(&mesh, 2000), 0, "{name}");
        assert_eq!(disagreements_of_bundles::<Straight>(&mesh, 100), 0, "{name}");
    }
}

struct NoSlackOfBoxes;

impl Twist for NoSlackOfBoxes {
    const BOXES: f64 = 0.0;
}

struct NoSlackOfTriangles;

impl Twist for NoSlackOfTriangles {
    const TRIANGLES: f64 = 0.0;
}

#[test]
fn without_slack_it_does_not() {
    let some = |name: &str| ["slivers", "coplanar", "twice", "hundredfold", "sphere"].contains(&name);
    let (mut boxes, mut triangles, mut bundles) = (0, 0, [0; 2]);
    for (_, mesh) in meshes().into_iter().filter(|(name, _)| some(name)) {
        boxes += disagreements::<NoSlackOfBoxes>(&mesh, 1000);
        triangles += disagreements::<NoSlackOfTriangles>(&mesh, 1000);
        bundles[0] += disagreements_of_bundles::<NoSlackOfBoxes>(&mesh, 100);
        bundles[1] += disagreements_of_bundles::<NoSlackOfTriangles>(&mesh, 100);
    }
    assert!(boxes > 0, "the test does not see that boxes need slack");
    assert!(triangles > 0, "the test does not see that triangles need slack");
    assert!(bundles.iter().all(|&wrong| wrong > 0), "nor that bundles need it: {bundles:?}");
}

/// Möller and Trumbore's test in f64, with the least of the barycentric coordinates.
fn by_edges(ray: &Ray, v: &[DVec3; 3]) -> (f64, f64) {
    let (e1, e2, s) = (v[1] - v[0], v[2] - v[0], ray.origin - v[0]);
    let (p, q) = (ray.dir.cross(e2), s.cross(e1));
    let det = e1.dot(p);
    let (b1, b2) = (s.dot(p) / det, ray.dir.dot(q) / det);
    (e2.dot(q) / det, b1.min(b2).min(1.0 - b1 - b2))
}

#[test]
fn hits_are_those_of_a_test_of_another_kind() {
    let (mut hits, mut edges) = (0, 0);
    for (name, mesh) in
        meshes().into_iter().filter(|(name, _)| ["small", "large", "far", "room", "sphere"].contains(name))
    {
        let tree = TriangleBvh::build(&mesh.positions, &mesh.triangles);
        let mut dice = Dice::new(17);
        let bounds = tree.bounds();
        for _ in 0..3000 {
            let from = bounds.centre() + 0.8 * dice.point() * (bounds.max - bounds.min);
            let ray = Ray::new(from, dice.point().normalize());
            let every: Vec<(f64, f64)> =
                (0..mesh.triangles.len()).map(|at| by_edges(&ray, &mesh.vertices(at))).collect();
            // Nearer to an edge than this, either answer is right: 1e-9 is 2⁻⁵³ magnified by 10⁷, by distance over size.
            if every.iter().any(|&(t, inside)| t > 0.0 && inside.abs() < 1e-9) {
                edges += 1;
                continue;
            }
            let ahead = |at: &usize| every[*at].0 > 0.0 && every[*at].1 > 0.0;
            let expected = (0..every.len()).filter(ahead).min_by(|&a, &b| every[a].0.total_cmp(&every[b].0));
            let hit = tree.closest(&ray);
            assert_eq!(hit.is_some(), expected.is_some(), "{name} {ray:?}");
            let (Some(hit), Some(expected)) = (hit, expected) else { continue };
            hits += 1;
            let t = every[expected].0;
            // Faces that coincide are told apart by rounding alone.
            let same = hit.triangle as usize == expected || (every[hit.triangle as usize].0 - t).abs() <= 1e-12 * t;
            assert!(same, "{name}: {} instead of {expected}", hit.triangle);
            assert!((hit.t - t).abs() <= 1e-9 * t.max(1e-3 * tree.extent()), "{name}: t = {} or {t}", hit.t);
            let v = mesh.vertices(hit.triangle as usize);
            let p = (1.0 - hit.b1 - hit.b2) * v[0] + hit.b1 * v[1] + hit.b2 * v[2];
            assert!(p.distance(ray.at(hit.t)) <= 1e-9 * tree.extent(), "{name}: {p}");
        }
    }
    assert!(hits > 2000 && edges < 1000, "{hits} hits, {edges} left out");
}

proptest! {
    #[test]
    fn any_triangles_and_rays(seed in any::<u64>(), count in 0..40_usize, grid in 1..6_u32) {
        // Coordinates on a coarse grid: vertices, edges and planes meet each other and the rays exactly.
        let mut dice = Dice::new(seed);
        let mut corner = || (dice.point() * f64::from(grid)).round();
        let mesh = Mesh::soup((0..count).map(|_| [corner(), corner(), corner()]).collect());
        let rays: Vec<Ray> = (0..50).map(|_| {
            let (from, to) = (corner(), corner());
            Ray::new(from, if from == to { DVec3::X } else { (to - from).normalize() })
        }).collect();
        for tree in mesh.trees() {
            for ray in &rays {
                let expected = mesh.closest(ray);
                prop_assert_eq!(tree.closest(ray), expected);
                prop_assert_eq!(tree.occluded(ray), expected.is_some());
            }
        }
    }
}

/// A closed surface: the icosahedron, its triangles cut in four `times` over, on the unit sphere.
fn icosphere(times: u32) -> Mesh {
    let g = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for k in 0..3 {
        for (a, b) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
            let mut v = [0.0; 3];
            (v[(k + 1) % 3], v[(k + 2) % 3]) = (a, b);
            corners.push(DVec3::from_array(v));
        }
    }
    // Its edges have length 2.
    let joined = |i: usize, j: usize| i != j && corners[i].distance(corners[j]) < 2.1;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i..12 {
            for k in j..12 {
                if joined(i, j) && joined(j, k) && joined(i, k) {
                    triangles.push([corners[i], corners[j], corners[k]].map(DVec3::normalize));
                }
            }
        }
    }
    for _ in 0..times {
        let cut = |[a, b, c]: [DVec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    Mesh::soup(triangles)
}

#[test]
fn no_ray_leaves_a_closed_surface() {
    let sphere = icosphere(5);
    assert_eq!(sphere.triangles.len(), 20 << 10);
    let tree = TriangleBvh::build(&sphere.positions, &sphere.triangles);
    let leaks = (0..1_000_000_u64).into_par_iter().filter(|&seed| {
        let mut dice = Dice::new(seed);
        let from = 0.55 * dice.point();
        // Two in three aimed exactly at a vertex or at a point of an edge.
        let v = sphere.vertices(dice.below(sphere.triangles.len()));
        let target = match seed % 3 {
            0 => dice.point(),
            1 => v[0],
            _ => v[0] + dice.number() * (v[1] - v[0]),
        };
        let ray = Ray::new(from, (target - from).normalize());
        tree.closest(&ray).is_none() || !tree.occluded(&ray)
    });
    assert_eq!(leaks.count(), 0);
}

#[test]
fn a_ray_that_leaves_a_surface_does_not_meet_it_again() {
    for (name, mesh) in [("sphere", icosphere(3)), ("room", room())] {
        let far = DVec3::new(300.0, -500.0, 100.0);
        for shift in [DVec3::ZERO, far, 1e4 * far] {
            let positions: Vec<DVec3> = mesh.positions.iter().map(|&p| p + shift).collect();
            let tree = TriangleBvh::build(&positions, &mesh.triangles);
            let mut dice = Dice::new(29);
            let mut again = [0; 2];
            for _ in 0..20_000 {
                let from = tree.bounds().centre() + 0.3 * dice.point();
                let ray = Ray::new(from, dice.point().normalize());
                let Some(hit) = tree.closest(&ray) else { continue };
                let v = mesh.triangles[hit.triangle as usize].map(|index| positions[index as usize]);
                let ng = (v[1] - v[0]).cross(v[2] - v[0]).normalize();
                // To either side, often nearly along the surface.
                let dir = (dice.point() + ng * 1e-4 * dice.point().x).reject_from(ng * dice.number().round());
                let Some(dir) = (dir + 1e-6 * dice.point().x * ng).try_normalize() else { continue };
                for (offset, again) in [true, false].into_iter().zip(&mut again) {
                    let p = ray.at(hit.t);
                    let p = if offset { offset_origin_within(p, ng, dir, tree.extent()) } else { p };
                    let next = tree.closest(&Ray::new(p, dir));
                    *again += usize::from(next.is_some_and(|next| next.triangle == hit.triangle));
                    // Without a look at the triangles at its ends, a ray that is off them meets the same.
                    let Some(next) = next.filter(|_| offset) else { continue };
                    let beside = [hit.triangle, next.triangle, NO_TRIANGLE];
                    let start = Ray { beside: [hit.triangle, NO_TRIANGLE, NO_TRIANGLE], ..Ray::new(p, dir) };
                    assert_eq!(tree.closest(&start), Some(next), "{name} at {shift}");
                    let w = mesh.triangles[next.triangle as usize].map(|index| positions[index as usize]);
                    let n = (w[1] - w[0]).cross(w[2] - w[0]).normalize();
                    let way = offset_origin_within(Ray::new(p, dir).at(next.t), n, -dir, tree.extent()) - p;
                    let between = Ray::up_to(p, way.normalize(), way.length());
                    assert!(!tree.occluded(&between), "{name} at {shift}");
                    assert!(!tree.occluded(&Ray { beside, ..between }), "{name} at {shift}");
                }
            }
            assert_eq!(again[0], 0, "{name} at {shift}");
            assert!(again[1] > 0, "{name} at {shift}: without an offset it must be seen to happen");
        }
    }
}

#[test]
fn what_is_no_ray_hits_nothing() {
    let mesh = room();
    for tree in mesh.trees() {
        let inside = DVec3::new(1.0, 2.0, 3.0);
        assert!(tree.closest(&Ray::new(inside, DVec3::Z)).is_some());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for k in 0..3 {
                let mut broken = inside;
                broken[k] = bad;
                let none = |ray: Ray| tree.closest(&ray).is_none() && !tree.occluded(&ray);
                assert!(none(Ray::new(broken, DVec3::Z)), "{bad} in the origin");
                assert!(none(Ray::new(inside, broken)), "{bad} in the direction");
            }
        }
        for t_max in [f64::NAN, 0.0, -1.0] {
            assert!(tree.closest(&Ray::up_to(inside, DVec3::Z, t_max)).is_none());
        }
        assert!(tree.closest(&Ray::new(inside, DVec3::ZERO)).is_none());
        assert!(tree.closest(&Ray::new(1e300 * inside, DVec3::Z)).is_none());
    }
}

#[test]
fn a_direction_of_any_length_gives_t_in_its_lengths() {
    let mesh = room();
    let tree = TriangleBvh::build(&mesh.positions, &mesh.triangles);
    let ray = Ray::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.6, 0.0, 0.8));
    let hit = tree.closest(&ray).unwrap();
    let long = tree.closest(&Ray::new(ray.origin, 1e5 * ray.dir)).unwrap();
    assert!(long.triangle == hit.triangle && (1e5 * long.t - hit.t).abs() <= 1e-14 * hit.t);
    assert!(!tree.occluded(&Ray::up_to(ray.origin, 1e5 * ray.dir, 0.99 * long.t)));
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let (_, mesh) = meshes().swap_remove(4);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let big: Vec<[u32; 3]> = mesh.triangles.iter().cycle().take(60_000).copied().collect();
        format!("{:?}", pool.install(|| TriangleBvh::build(&mesh.positions, &big)))
    };
    assert!(build(1) == build(3));
}
