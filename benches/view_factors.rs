//! View factors without anything in between: pairs per second for the squares, and for the triangles, of a unit box with two
//! blocks in it, by the tolerance; what each way costs for a pair; and what a hemicube costs for all of them.
//!
//! The error against the contours is printed with each tolerance.
#![allow(missing_docs, reason = "criterion's macros make undocumented functions")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use whitefurnace::glam::DVec3;
use whitefurnace::render::radiosity::form::hemicube::Hemicube;
use whitefurnace::render::radiosity::form::rectangles::{self, Rectangle};
use whitefurnace::render::radiosity::form::{Quadrature, contour, of_pair, point};
use whitefurnace::render::radiosity::polygon::Polygon;

const TOLERANCES: [f64; 4] = [1e-3, 1e-4, 1e-6, 1e-8];

/// A prime that is coprime to the lengths of rows: every so many-th pair is taken.
const STEP: usize = 149;

fn polygon(corners: &[DVec3]) -> Polygon {
    Polygon::new(corners.to_vec()).expect("corners of a square or a triangle")
}

fn grid(out: &mut Vec<Polygon>, corner: DVec3, x: DVec3, y: DVec3, [columns, rows]: [u32; 2]) {
    let (x, y) = (x / f64::from(columns), y / f64::from(rows));
    for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
        let p = corner + x * f64::from(i) + y * f64::from(j);
        out.push(polygon(&[p, p + x, p + x + y, p + y]));
    }
}

fn block(out: &mut Vec<Polygon>, corner: DVec3, size: DVec3, turn: f64, [around, up]: [u32; 2]) {
    let (sin, cos) = turn.sin_cos();
    let (x, y, z) = (DVec3::new(cos, sin, 0.0) * size.x, DVec3::new(-sin, cos, 0.0) * size.y, DVec3::Z * size.z);
    grid(out, corner + z, x, y, [around, around]);
    for (corner, along) in [(corner, x), (corner + x, y), (corner + x + y, -x), (corner + y, -y)] {
        grid(out, corner, along, z, [around, up]);
    }
}

/// The unit box in n × n squares a side, and two blocks.
fn room(n: u32) -> Vec<Polygon> {
    let mut out = Vec::new();
    let (o, x, y, z) = (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z);
    for (corner, u, v) in [(o, x, y), (z, y, x), (o, z, x), (y, x, z), (o, y, z), (x, z, y)] {
        grid(&mut out, corner, u, v, [n, n]);
    }
    block(&mut out, DVec3::new(0.25, 0.1, 0.0), DVec3::splat(0.3), 0.3, [n / 3, n / 3]);
    block(&mut out, DVec3::new(0.6, 0.5, 0.0), DVec3::new(0.3, 0.3, 0.6), -0.3, [n / 3, 2 * n / 3]);
    out
}

fn halves(squares: &[Polygon]) -> Vec<Polygon> {
    let half = |c: &[DVec3], i: usize| polygon(&[c[0], c[i], c[i + 1]]);
    squares.iter().flat_map(|square| [1, 2].map(|i| half(square.corners(), i))).collect()
}

fn pairs(patches: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..patches).flat_map(|i| (0..i).map(move |j| (i, j))).step_by(STEP)
}

fn meshes() -> [(&'static str, Vec<Quadrature>); 2] {
    let prepared = |room: Vec<Polygon>| room.iter().map(Quadrature::of).collect();
    [("squares", prepared(room(16))), ("triangles", prepared(halves(&room(11))))]
}

#[allow(clippy::print_stdout, reason = "a bench reports on standard output")]
fn say_errors(name: &str, patches: &[Quadrature], tolerance: f64) {
    let (mut worst, mut squares, mut count) = (0.0_f64, 0.0, 0.0);
    for (i, j) in pairs(patches.len()) {
        let exact = contour::exchange(patches[i].polygon(), patches[j].polygon());
        if exact > 0.0 {
            // Less the rounding of the contours: 1e-15 of the product of the perimeters.
            let rounding = 6.4e-14 * patches[i].polygon().radius() * patches[j].polygon().radius();
            let difference = (of_pair(&patches[i], &patches[j], tolerance).0 - exact).abs();
            let error = (difference - rounding).max(0.0) / exact;
            worst = worst.max(error);
            squares += error * error;
            count += 1.0;
        }
    }
    let rms = (squares / count).sqrt();
    let n = patches.len();
    println!("{n} {name}, tolerance {tolerance:e}: relative error at most {worst:.1e}, r.m.s. {rms:.1e}");
}

fn all_pairs(c: &mut Criterion) {
    for (name, patches) in meshes() {
        let mut group = c.benchmark_group(format!("pairs_of_{name}"));
        group.throughput(Throughput::Elements(pairs(patches.len()).count() as u64));
        for tolerance in TOLERANCES {
            say_errors(name, &patches, tolerance);
            group.bench_function(BenchmarkId::from_parameter(format!("{tolerance:e}")), |b| {
                let sum =
                    || pairs(patches.len()).map(|(i, j)| of_pair(&patches[i], &patches[j], tolerance).0).sum::<f64>();
                b.iter(|| black_box(sum()));
            });
        }
        group.finish();
    }
}

fn one_pair(c: &mut Criterion) {
    let square = |corner: DVec3, x: DVec3, y: DVec3| polygon(&[corner, corner + x, corner + x + y, corner + y]);
    let floor = square(DVec3::ZERO, DVec3::X, DVec3::Y);
    let wall = square(DVec3::ZERO, DVec3::Y, DVec3::Z);
    let slope = square(DVec3::ZERO, DVec3::Y, DVec3::new(0.6, 0.0, 0.8));
    let mut group = c.benchmark_group("one_pair");
    group.bench_function("contour_hinged_90", |b| b.iter(|| contour::exchange(black_box(&floor), black_box(&wall))));
    group.bench_function("contour_hinged_53", |b| b.iter(|| contour::exchange(black_box(&floor), black_box(&slope))));
    let rectangles = Rectangle::of(&floor).zip(Rectangle::of(&wall)).expect("rectangles");
    group.bench_function("rectangles", |b| b.iter(|| rectangles::exchange(black_box(&rectangles.0), &rectangles.1)));
    let eye = DVec3::new(0.3, 0.4, 0.0);
    group.bench_function("point", |b| b.iter(|| point::factor(black_box(eye), DVec3::Z, &wall)));
    group.finish();
}

fn hemicubes(c: &mut Criterion) {
    let patches = room(16);
    let mut shares = vec![0.0; patches.len()];
    let mut group = c.benchmark_group("hemicube");
    group.throughput(Throughput::Elements(patches.len() as u64));
    for resolution in [64, 128, 256, 512] {
        let mut cube = Hemicube::new(resolution).expect("an even resolution");
        group.bench_function(BenchmarkId::from_parameter(resolution), |b| {
            let at = (DVec3::new(0.31, 0.42, 0.0), DVec3::Z, 0.3);
            b.iter(|| cube.shares(black_box(at), (0..).zip(&patches), &mut shares));
        });
    }
    group.finish();
}

criterion_group!(benches, all_pairs, one_pair, hemicubes);
criterion_main!(benches);
