//! The rendering equation where its solution is known: light in a closed room, reflection by reflection.

use glam::DVec3;

use super::{File, KNOWN, MEASURED, SEED, Set, csv, rounded, scene};
use crate::render::path::{PathTracer, Strategy};
use crate::render::probe::Probe;
use crate::report::contact_sheet::tracer;
use crate::sampling::warp::uniform_sphere;
use crate::scene::Ray;
use crate::scene::builtin::furnace_radiance;

/// `furnace.csv`.
pub const SET: Set = Set {
    name: "reflections in a furnace",
    files: &[File {
        name: "furnace.csv",
        about: "Radiance in a closed room whose walls emit e and reflect rho, after a number of reflections",
        columns: COLUMNS,
    }],
    make: || vec![csv(COLUMNS, rows())],
};

const COLUMNS: &[(&str, &str)] = &[
    ("rho", "reflectance of the walls"),
    ("e", "radiance that the walls emit; 1 - rho, so that all rooms end at 1"),
    ("bounces", "largest number of reflections, inf for no limit"),
    ("closed_form", "e (1 - rho^(bounces + 1)) / (1 - rho)"),
    ("strategy", "how the path tracer finds light"),
    ("mean", "mean of the paths"),
    ("std_err", "its standard error; next to 0 for bsdf, whose paths all bring the same"),
    ("samples", "paths"),
];

const SAMPLES: u64 = 8192;
/// Reflections, up to where the brighter room still has a tenth of its light to come.
const MOST: u32 = 10;

const STRATEGIES: [(&str, Strategy); 4] = [
    ("bsdf", Strategy::Bsdf),
    ("direct", Strategy::Direct),
    ("mis", Strategy::Mis),
    ("random-connect", Strategy::RandomConnect),
];

fn rows() -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for (rho, e) in [(0.5, 0.5), (0.8, 0.2)] {
        let room = scene("furnace-box", &[("rho", rho.to_string()), ("e", e.to_string())]);
        for bounces in (0..=MOST).map(Some).chain([None]) {
            for (name, strategy) in STRATEGIES {
                let tracer = PathTracer { strategy, ..tracer(bounces) };
                let probe = Probe { seed: SEED, number: rows.len() as u64, samples: SAMPLES };
                let [moments, ..] = probe.estimate(&tracer, &room, &|sampler| {
                    Ray::new(DVec3::new(0.1, -0.2, 0.3), uniform_sphere(sampler.next_2d()))
                });
                rows.push(vec![
                    rho.to_string(),
                    e.to_string(),
                    bounces.map_or("inf".into(), |r| r.to_string()),
                    rounded(furnace_radiance(rho, e, bounces), KNOWN),
                    name.into(),
                    rounded(moments.mean(), MEASURED),
                    // Below that there is nothing but rounding.
                    rounded(if moments.std_err() < 1e-12 { 0.0 } else { moments.std_err() }, MEASURED),
                    moments.count().to_string(),
                ]);
            }
        }
    }
    rows
}
