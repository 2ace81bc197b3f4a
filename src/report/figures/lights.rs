//! Why light and model are both sampled: six ways to one irradiance, and Veach's highlights.

use rayon::prelude::*;

use super::rates::{ERRORS, FITS, Row, study, tables};
use super::{File, MEASURED, Set, csv, literal, rounded, subject};
use crate::converge::highlight::highlight;
use crate::converge::irradiance::irradiance;
use crate::math::sphere::direction;
use crate::sampling::sampler::SamplerKind;

/// `irradiance.csv` and `irradiance_fits.csv`.
pub const IRRADIANCE: Set = Set {
    name: "six ways to an irradiance",
    files: &[
        File {
            name: "irradiance.csv",
            about: "Error of six estimators of the irradiance from a unit square at distance 1",
            columns: ERRORS,
        },
        File {
            name: "irradiance_fits.csv",
            about: "Rates and standard deviations of the six estimators, against what is known of them",
            columns: FITS,
        },
    ],
    make: || tables(&six_ways()),
};

/// `highlights.csv`.
pub const HIGHLIGHTS: Set = Set {
    name: "Veach's highlights",
    files: &[File {
        name: "highlights.csv",
        about: "Spread of one sample of a round light's highlight on a plate: width of the lobe against size of the light",
        columns: HIGHLIGHT_COLUMNS,
    }],
    make: || vec![csv(HIGHLIGHT_COLUMNS, highlights())],
};

const HIGHLIGHT_COLUMNS: &[(&str, &str)] = &[
    ("alpha", "slope width of the plate's GGX lobe; the eye is at 45 degrees"),
    ("half_angle_deg", "half of the angle that the light fills, about the mirror direction"),
    (
        "estimator",
        "how the light's direction is drawn; balance and power take one draw from the light and one from the lobe",
    ),
    ("exact", "reflected radiance of a light of radiance 1"),
    ("sigma_exact", "standard deviation of one sample, integrated"),
    ("sigma", "the same, measured"),
    ("samples", "how many"),
];

/// Means of each number of samples. 64 leave the slope uncertain by .036 at 99 %.
const REPLICATES: u64 = 64;

fn six_ways() -> Vec<Row> {
    let target = literal(irradiance("unit-square").ok_or("unit-square"));
    let counts: Vec<u64> = (4..=14).map(|k| 1 << k).collect();
    let independent = SamplerKind::Independent;
    let numbered = target.estimators.iter().enumerate();
    numbered.map(|(i, estimator)| study(&target, estimator, independent, &counts, REPLICATES, i as u64)).collect()
}

const ALPHAS: [f64; 4] = [0.01, 0.05, 0.1, 0.25];
const HALF_ANGLES_DEG: [f64; 5] = [0.25, 1.0, 4.0, 10.0, 25.0];

fn highlights() -> Vec<Vec<String>> {
    let cells: Vec<(f64, f64)> =
        ALPHAS.iter().flat_map(|&alpha| HALF_ANGLES_DEG.iter().map(move |&half| (alpha, half))).collect();
    let wo = direction(45_f64.to_radians(), 0.0);
    let cell = |(at, &(alpha, half_angle_deg)): (usize, &(f64, f64))| {
        let plate = subject(&format!("ggx:alpha={alpha}"));
        let target = highlight("highlight", &*plate, wo, half_angle_deg.to_radians());
        let row = |(i, estimator)| {
            let independent = SamplerKind::Independent;
            // 2¹⁶ samples in one mean after the other; the rates are those of independent samples and not shown.
            let Row { found, sigma, .. } = &study(&target, estimator, independent, &[1024], 64, (4 * at + i) as u64);
            vec![
                alpha.to_string(),
                half_angle_deg.to_string(),
                estimator.name.to_string(),
                rounded(target.exact, MEASURED),
                sigma.map_or(String::new(), |sigma| rounded(sigma, MEASURED)),
                rounded(found.samples.variance().sqrt(), MEASURED),
                found.samples.count().to_string(),
            ]
        };
        target.estimators.iter().enumerate().map(row).collect::<Vec<_>>()
    };
    cells.par_iter().enumerate().flat_map(cell).collect()
}
