//! Rays per second on two threads, and the time of a build.
//!
//! `WHITEFURNACE_TRI=scene.tri WHITEFURNACE_RAYS=folder cargo bench --bench rays` takes the triangles of a file (u32 vertices,
//! u32 triangles, 12 f32 that are skipped, f32 coordinates, u32 indices) and the rays of the folder's `*.rays` files (7 f32 each:
//! origin, direction, t_max), so that another tracer can be given the same. Without them it makes a torus knot and rays
//! of its own. Rays in a set called `shadow` only ask whether there is a hit. `WHITEFURNACE_REPEATS` defaults to 5.

use std::error::Error;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use std::{env, fs, thread};

use whitefurnace::glam::DVec3;
use whitefurnace::sampling::stream::{stream, uniform};
use whitefurnace::scene::bvh::TriangleBvh;
use whitefurnace::scene::ray::{Ray, offset_origin};

const THREADS: usize = 2;

/// A thread takes so many rays at a time.
const SHARE: usize = 1 << 14;

struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

struct Set {
    name: String,
    rays: Vec<[f32; 7]>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let repeats = env::var("WHITEFURNACE_REPEATS").ok().map_or(Ok(5), |text| text.parse())?;
    let mesh = match env::var_os("WHITEFURNACE_TRI") {
        Some(file) => read_mesh(Path::new(&file))?,
        None => knot(1024, 128),
    };
    let mut builds = Vec::new();
    let mut tree = TriangleBvh::build(&[], &[]);
    for _ in 0..repeats {
        let start = Instant::now();
        tree = TriangleBvh::build(&mesh.positions, &mesh.triangles);
        builds.push(start.elapsed().as_secs_f64());
    }
    builds.sort_by(f64::total_cmp);
    say(&format!(
        "build {} triangles: min {:.4} s, med {:.4} s, {:.1} bytes per triangle",
        mesh.triangles.len(),
        builds[0],
        builds[builds.len() / 2],
        tree.memory_bytes() as f64 / mesh.triangles.len() as f64
    ));
    let sets = match env::var_os("WHITEFURNACE_RAYS") {
        Some(folder) => read_sets(Path::new(&folder))?,
        None => own_sets(&tree, &mesh),
    };
    for set in &sets {
        measure(&tree, set, repeats);
    }
    Ok(())
}

#[allow(clippy::print_stdout, reason = "a bench reports on standard output")]
fn say(line: &str) {
    println!("{line}");
}

fn ray(r: &[f32; 7]) -> Ray {
    let [x, y, z, dx, dy, dz, t_max] = r.map(f64::from);
    Ray::up_to(DVec3::new(x, y, z), DVec3::new(dx, dy, dz), t_max)
}

fn measure(tree: &TriangleBvh, set: &Set, repeats: usize) {
    let occlusion = set.name == "shadow";
    let mut rates = Vec::new();
    let mut hits = 0;
    // The first round only warms up.
    for round in 0..=repeats {
        let (next, found) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let start = Instant::now();
        let work = || {
            loop {
                let from = next.fetch_add(SHARE, Ordering::Relaxed);
                let Some(share) = set.rays.get(from..set.rays.len().min(from + SHARE)) else { break };
                let count = if occlusion {
                    share.iter().filter(|r| tree.occluded(&ray(r))).count()
                } else {
                    share.iter().filter(|r| tree.closest(&ray(r)).is_some()).count()
                };
                found.fetch_add(count, Ordering::Relaxed);
            }
        };
        thread::scope(|scope| (0..THREADS).for_each(|_| drop(scope.spawn(work))));
        if round > 0 {
            rates.push(set.rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        }
        hits = found.into_inner();
    }
    rates.sort_by(f64::total_cmp);
    say(&format!(
        "{:<10} rays {} hit {:.3}  Mrays/s min {:.2} med {:.2} max {:.2}",
        set.name,
        set.rays.len(),
        hits as f64 / set.rays.len() as f64,
        rates[0],
        rates[rates.len() / 2],
        rates[rates.len() - 1]
    ));
}

fn words(file: &Path) -> Result<Vec<[u8; 4]>, Box<dyn Error>> {
    let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(bytes.as_chunks::<4>().0.to_vec())
}

fn read_mesh(file: &Path) -> Result<Mesh, Box<dyn Error>> {
    let words = words(file)?;
    let short = || format!("{}: shorter than it says", file.display());
    let count = |at: usize| words.get(at).map(|&w| u32::from_le_bytes(w) as usize).ok_or_else(short);
    let (vertices, triangles) = (count(0)?, count(1)?);
    let coordinates = words.get(14..14 + 3 * vertices).ok_or_else(short)?;
    let indices = words.get(14 + 3 * vertices..14 + 3 * (vertices + triangles)).ok_or_else(short)?;
    let position = |w: &[[u8; 4]; 3]| DVec3::from_array(w.map(|w| f64::from(f32::from_le_bytes(w))));
    Ok(Mesh {
        positions: coordinates.as_chunks::<3>().0.iter().map(position).collect(),
        triangles: indices.as_chunks::<3>().0.iter().map(|w| w.map(u32::from_le_bytes)).collect(),
    })
}

fn read_sets(folder: &Path) -> Result<Vec<Set>, Box<dyn Error>> {
    let mut sets = Vec::new();
    for name in ["primary", "bounce", "bounce-rnd", "bounce2", "shadow"] {
        let words = words(&folder.join(format!("{name}.rays")))?;
        let rays = words.as_chunks::<7>().0.iter().map(|w| w.map(f32::from_le_bytes)).collect();
        sets.push(Set { name: name.into(), rays });
    }
    Ok(sets)
}

/// A tube around a (2, 3) torus knot, with bumps: 2 · along · around triangles.
fn knot(along: u32, around: u32) -> Mesh {
    let curve = |u: f64| {
        let r = 2.0 + (3.0 * u).cos();
        DVec3::new(r * (2.0 * u).cos(), r * (2.0 * u).sin(), -(3.0 * u).sin())
    };
    let turn = std::f64::consts::TAU;
    let mut positions = Vec::new();
    for i in 0..along {
        let u = f64::from(i) / f64::from(along) * turn;
        let tangent = (curve(u + 1e-4) - curve(u - 1e-4)).normalize();
        let side = tangent.any_orthonormal_vector();
        let normal = tangent.cross(side);
        for j in 0..around {
            let w = f64::from(j) / f64::from(around) * turn;
            let radius = 0.5 + 0.06 * (24.0 * u).sin() * (6.0 * w).cos();
            positions.push(curve(u) + radius * (w.cos() * normal + w.sin() * side));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..along {
        for j in 0..around {
            let (i2, j2) = ((i + 1) % along, (j + 1) % around);
            let [a, b, c, d] = [(i, j), (i2, j), (i2, j2), (i, j2)].map(|(i, j)| i * around + j);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh { positions, triangles }
}

/// Rays from a pinhole, one bounce from where they hit, and from there to a point far away.
fn own_sets(tree: &TriangleBvh, mesh: &Mesh) -> Vec<Set> {
    const RESOLUTION: u32 = 512;
    let mut rng = stream(1, 0, 0);
    let mut sphere = || {
        let (z, phi) = (2.0 * uniform(&mut rng) - 1.0, std::f64::consts::TAU * uniform(&mut rng));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    };
    let packed = |origin: DVec3, dir: DVec3, t_max: f64| {
        [origin.x, origin.y, origin.z, dir.x, dir.y, dir.z, t_max].map(|x| x as f32)
    };
    let (mut primary, mut bounce, mut shadow) = (Vec::new(), Vec::new(), Vec::new());
    for pixel in 0..RESOLUTION * RESOLUTION {
        let on = |k: u32| (f64::from(k) + 0.5) / f64::from(RESOLUTION) - 0.5;
        let eye = DVec3::new(0.0, -5.5, 7.5);
        let right_up = DVec3::new(on(pixel % RESOLUTION), 0.8 * on(pixel / RESOLUTION), 0.6 * on(pixel / RESOLUTION));
        let dir = (-eye.normalize() + 0.83 * right_up).normalize();
        primary.push(packed(eye, dir, f64::INFINITY));
        let camera = Ray::new(eye, dir);
        let Some(hit) = tree.closest(&camera) else { continue };
        let v = mesh.triangles[hit.triangle as usize].map(|index| mesh.positions[index as usize]);
        let normal = (v[1] - v[0]).cross(v[2] - v[0]).normalize();
        let outside = normal * -normal.dot(dir).signum();
        // The sets are f32, whose rounding needs 2⁻²⁰ instead of 2⁻⁴⁴.
        let point = camera.at(hit.t);
        let start = point + (offset_origin(point, normal, outside) - point) * f64::from(1_u32 << 24);
        bounce.push(packed(start, (outside + sphere()).normalize(), f64::INFINITY));
        let to = 8.0 * sphere() - start;
        shadow.push(packed(start, to.normalize(), to.length()));
    }
    [("primary", primary), ("bounce", bounce), ("shadow", shadow)]
        .map(|(name, rays)| Set { name: name.into(), rays })
        .into()
}
