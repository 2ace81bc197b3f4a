//! Models of measured materials, and the files they come from.

use std::path::Path;

use super::Bsdf;
use super::subject::SubjectError;

pub(super) mod abc;
mod fits_csv;
mod half_table;
pub(super) mod sgd;

pub use abc::Abc;
pub use sgd::{Sgd, SgdParams};

use fits_csv::{FitsCsv, Kind, Row};

/// A model and the text of the subject that names it.
pub type Named = (String, Box<dyn Bsdf>);

/// Every material of a table of fits, SGD or ABC by its header.
pub fn load_fits(path: &Path) -> Result<Vec<Named>, SubjectError> {
    let csv = FitsCsv::read(path)?;
    let file = path.display().to_string();
    // A comma would end the value, unless it stands in parentheses.
    let file = if file.contains(',') { format!("({file})") } else { file };
    let one = |row: &Row| -> Result<Named, SubjectError> {
        Ok(match csv.kind {
            Kind::Sgd => (format!("sgd:file={file},material={}", row.name), Box::new(Sgd::from_row(&csv, row)?)),
            Kind::Abc => (format!("abc:file={file},material={}", row.name), Box::new(Abc::from_row(&csv, row)?)),
        })
    };
    csv.rows.iter().map(one).collect()
}

#[cfg(test)]
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
mod tests {
    use super::*;
    use crate::bsdf::{contract, subject};
    use crate::math::color::Rgb;
    use crate::math::sphere::direction;
    use glam::DVec3;
    use std::f64::consts::{FRAC_PI_2, TAU};
    use std::path::PathBuf;

    /// The published table `name`, if the shared data are there.
    fn published(name: &str) -> Option<PathBuf> {
        let root = std::env::var_os("WHITEFURNACE_DATA").map_or_else(|| "../shared/data".into(), PathBuf::from);
        let path = root.join("brdf/fits").join(name);
        let found = path.exists();
        if !found {
            eprintln!("skipped: {} is not there; set WHITEFURNACE_DATA", path.display());
        }
        found.then_some(path)
    }

    fn view(degrees: f64) -> DVec3 {
        direction(degrees.to_radians(), 0.0)
    }

    fn max_albedo(model: &dyn Bsdf, degrees: f64) -> f64 {
        let wo = view(degrees);
        let channel = |c: usize| contract::hemisphere(wo, 1e-4, |wi| model.eval(wo, wi).0[c] * wi.z);
        channel(0).max(channel(1)).max(channel(2))
    }

    /// The midpoint rule on cells of angle, `n` in θ and φ.
    fn max_albedo_on_a_grid(model: &dyn Bsdf, degrees: f64, n: [usize; 2]) -> f64 {
        let at = |i: usize, n: usize, range: f64| (i as f64 + 0.5) / n as f64 * range;
        let mut sum = Rgb::BLACK;
        for theta in (0..n[0]).map(|i| at(i, n[0], FRAC_PI_2)) {
            let ring: Rgb = (0..n[1]).map(|j| model.eval(view(degrees), direction(theta, at(j, n[1], TAU)))).sum();
            sum += ring * (theta.cos() * theta.sin());
        }
        (sum * (FRAC_PI_2 * TAU / (n[0] * n[1]) as f64)).max_channel()
    }

    #[test]
    fn the_coarse_quadrature_of_the_literature_sees_one_sgd_fit_gain_energy() {
        let Some(path) = published("sgd_merl.csv") else { return };
        let fits = load_fits(&path).unwrap();
        assert_eq!(fits.len(), 100);
        for (subject, model) in &fits {
            let found = [5.0, 45.0, 75.0, 85.0].map(|degrees| max_albedo_on_a_grid(model, degrees, [180, 180]));
            if subject.ends_with("material=white-paint") {
                for (found, expected) in found.into_iter().zip([0.36, 0.49, 1.42, 2.13]) {
                    // Two decimals are published.
                    assert!((found - expected).abs() <= 0.005, "white-paint: {found}, not {expected}");
                }
            } else {
                assert!(found.iter().all(|&a| a <= 1.0), "{subject}: {found:?}");
            }
        }
    }

    #[test]
    fn resolved_quadrature_sees_five_sgd_fits_gain_energy_at_85_degrees() {
        let Some(path) = published("sgd_merl.csv") else { return };
        let gains = |(subject, model): &Named| {
            let exact = max_albedo(model, 85.0);
            // The lobes are a fraction of a degree wide: a grid of 2 degrees in azimuth sums to half their light.
            let name = subject.split_once("material=").map(|(_, name)| name.to_owned());
            if exact > 0.98 {
                // 0.0225 degrees in azimuth resolve the narrowest of them by its half.
                let fine = max_albedo_on_a_grid(model, 85.0, [250, 16_000]);
                assert!((fine - exact).abs() < 5e-3, "{subject}: {fine} on a fine grid, {exact} adaptively");
            }
            (exact > 1.0).then_some(name).flatten()
        };
        let found: Vec<String> = load_fits(&path).unwrap().iter().filter_map(gains).collect();
        let expected = [
            "color-changing-paint1",
            "gold-metallic-paint2",
            "two-layer-silver",
            "white-paint",
            "yellow-matte-plastic",
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn no_abc_fit_gains_energy_at_these_angles() {
        let Some(path) = published("abc_merl.csv") else { return };
        for (subject, model) in load_fits(&path).unwrap() {
            for degrees in [5.0, 45.0, 75.0, 85.0, 89.9] {
                assert!(max_albedo(&model, degrees) <= 1.0, "{subject} at {degrees} degrees");
            }
        }
    }

    #[test]
    fn every_published_fit_is_total_and_consistent() {
        for name in ["sgd_merl.csv", "abc_merl.csv"] {
            let Some(path) = published(name) else { return };
            for (text, model) in load_fits(&path).unwrap() {
                contract::assert_total(&model);
                assert!(subject::parse(&text).is_ok(), "{text}");
            }
        }
    }

    #[test]
    fn samplers_draw_from_their_pdf() {
        let sgd = SgdParams {
            rho_d: Rgb::grey(0.2),
            rho_s: Rgb::new(0.5, 0.4, 0.3),
            alpha: Rgb::new(0.05, 0.1, 0.02),
            p: Rgb::grey(0.5),
            f0: Rgb::grey(0.3),
            f1: Rgb::grey(0.1),
            kap: Rgb::grey(15.0),
            lambda: Rgb::grey(2.0),
            c: Rgb::grey(1e-3),
            k: Rgb::grey(20.0),
            theta0: Rgb::grey(0.1),
        };
        let models: [Box<dyn Bsdf>; 3] = [
            Box::new(Sgd::new(sgd).unwrap()),
            Box::new(Abc::new(0.1, 3.0, 200.0, 1.2, 1.5).unwrap()),
            Box::new(Abc::new(0.0, 0.0, 200.0, 1.2, 1.5).unwrap()),
        ];
        for model in models {
            contract::assert_total(&model);
            for theta in [0.0, 0.9, 1.5] {
                // The discrepancy of the points at the horizon's edge.
                contract::assert_draws_follow_pdf(&model, direction(theta, 0.6), 2e-4);
            }
        }
    }

    #[test]
    fn hostile_tables_get_one_line_with_the_place_and_what_is_allowed() {
        let header = "name,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C,ior";
        let error = |text: &str| {
            let read = FitsCsv::parse(Path::new("t.csv"), text);
            let error = read.and_then(|csv| Abc::from_row(&csv, csv.find("x")?).map(|_| ())).unwrap_err().to_string();
            assert!(error.starts_with("t.csv: ") && !error.contains('\n'), "{error}");
            error
        };
        assert!(error("").contains("line 1: no header"));
        assert!(error("# only a comment\n").contains("no header"));
        assert!(error("name,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C\nx,1,1,1,1,1,1,1,1").contains("line 1: no column ior"));
        assert!(error(header).contains("line 1: a header without materials"));
        assert!(error(&format!("#\n{header}\nx,1,1,1")).contains("line 3: 4 fields, but the header has 10"));
        assert!(error(&format!("{header}\nx,.1,.1,.1,1,1,1,NaN,1,1.5")).contains("line 2: column B: 'NaN'"));
        assert!(error(&format!("{header}\nx,.1,.1,.1,1e999,1,1,9,1,1.5")).contains("column A_r: '1e999'"));
        assert!(error(&format!("{header}\nx,.1,.1,.1,,1,1,9,1,1.5")).contains("column A_r: ''"));
        assert!(error(&format!("{header}\nx,.1,.1,.1,1,1,1,9,1,.5")).contains("line 2: abc: ior = 0.5 is not allowed"));
        assert!(error(&format!("{header}\nxx,.1,.1,.1,1,1,1,9,1,.5")).contains("no material x; did you mean xx?"));
        let row = "x,.1,.1,.1,1,1,1,9,1,1.5";
        assert!(error(&format!("{header}\n{row}\n{row}")).contains("line 3: column name: x is already on line 2"));
        assert!(FitsCsv::parse(Path::new("t"), &format!("\u{feff}{header}\r\n{row}\r\n")).is_ok());
    }

    #[test]
    fn what_is_no_table_gets_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("binary"), [b'a', b'\n', 0xff, 0xfe]).unwrap();
        std::fs::write(at("huge"), vec![b'#'; (4 << 20) + 1]).unwrap();
        for (name, says) in
            [("", "is not a file"), ("none", "cannot be read"), ("binary", "line 2: not UTF-8"), ("huge", "4 MiB")]
        {
            let error = load_fits(&at(name)).unwrap_err().to_string();
            assert!(error.contains(says) && !error.contains('\n'), "{error}");
        }
    }
}
