//! The numbers behind the README's figure: Phong's lobe divided by n·l, from both sides.
//!
//! `whitefurnace notebooks-data` writes them, the figure itself and all the others; `report::figures` is where they come from.
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use whitefurnace::prelude::*;
use whitefurnace::report::figures::phong::{albedos, onset_deg};
use whitefurnace::report::table::{Align, Table, short};

fn main() {
    let norm = PhongNorm::DensityNPlus1;
    let onset = onset_deg(100.0, norm);
    let mut table = Table::new(&["theta_deg", "albedo, eye fixed", "albedo, light fixed"].map(|h| (h, Align::Right)));
    let forms = albedos(&[100.0]);
    let side = |side| forms.iter().filter(move |a| a.norm == norm && a.divide && a.side == side);
    for (eye, light) in side(Side::Eye).zip(side(Side::Light)) {
        // The eye never sees the gain; the light shows it from 80.15° on. Both forms of each value agree within its error.
        assert!(eye.closed_form <= 1.0 + 1e-12, "a rounding at the normal, where it is 1");
        // The onset is a root of the closed form, the albedo here an integral.
        assert_eq!(light.quadrature > 1.0, light.theta_deg > onset, "{light:?}");
        // 1e-12: roundings, where the bound itself is 0.
        assert!([eye, light].iter().all(|a| (a.closed_form - a.quadrature).abs() <= a.error + 1e-12));
        table.row([short(eye.theta_deg), short(eye.closed_form), short(light.closed_form)]);
    }
    println!("{}", table.text(""));
    println!("with the light fixed, energy is gained from {onset:.2} degrees on");
}
