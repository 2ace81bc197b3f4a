//! The README's figure and the numbers behind it. With a folder as argument, both are written there:
//!
//! `cargo run --release --example 05_figures -- notebooks-data`
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::env;
use std::error::Error;
use std::fs;
use std::path::PathBuf;

use whitefurnace::math::sphere::direction;
use whitefurnace::prelude::*;
use whitefurnace::report::plot;
use whitefurnace::report::probe::albedo_curve;
use whitefurnace::report::table::{Align, Table};

fn main() -> Result<(), Box<dyn Error>> {
    let phong = Phong::new(100.0, 0.0, 1.0, PhongNorm::DensityNPlus1)?.with_division(true);
    let (eye, light) = (albedo_curve(&phong, Side::Eye), albedo_curve(&phong, Side::Light));
    let figure = plot::albedo(&eye, &light).svg()?;

    let hemisphere = Hemisphere { tol: 1e-9, ..Hemisphere::default() };
    let columns = ["theta_deg", "albedo_eye", "albedo_light"];
    let mut numbers = Table::new(&columns.map(|name| (name, Align::Right)));
    for theta_deg in [0.0, 30.0, 60.0, 70.0, 75.0, 80.0, 85.0, 87.0, 89.0_f64] {
        let w = direction(theta_deg.to_radians(), 0.0);
        let [eye, light] = [Side::Eye, Side::Light].map(|side| hemisphere.albedo(&phong, side, w));
        assert!(eye.resolved && light.resolved);
        // 1 and the tolerance: the eye never sees the gain, the light shows it from 80.16° on.
        assert!(eye.value.max_channel() <= 1.0 + 1e-9);
        assert_eq!(light.value.max_channel() > 1.0, theta_deg > 80.16, "{theta_deg}");
        // Nine decimals, as many as the tolerance allows.
        let shown = [eye, light].map(|a| format!("{:.9}", a.value.max_channel()));
        let [eye, light] = shown;
        numbers.row([theta_deg.to_string(), eye, light]);
    }
    println!("{}", numbers.text(""));
    if let Some(folder) = env::args_os().nth(1).map(PathBuf::from) {
        fs::write(folder.join("two_sides_of_phong.svg"), figure)?;
        fs::write(folder.join("two_sides_of_phong.csv"), numbers.csv())?;
    }
    Ok(())
}
