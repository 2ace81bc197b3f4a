//! The two forms of Phong's model that lectures teach: one passes the furnace of a path tracer and still makes energy.
//!
//! With the eye fixed, as a backward path tracer has it, the form divided by n·l reflects at most what comes in. With
//! the *light* fixed, a beam at grazing comes out brighter than it went in: the form is not reciprocal.
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::error::Error;

use whitefurnace::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let first = Phong::new(100.0, 0.0, 1.0, PhongNorm::AlbedoNPlus2)?;
    let second = Phong::new(100.0, 0.0, 1.0, PhongNorm::DensityNPlus1)?.with_division(true);
    let laws = ["reciprocity", "energy_eye", "energy_light"];
    let suite = Suite { only: laws.to_vec(), ..Suite::default() };
    let (kept, gained) = (suite.run(&first), suite.run(&second));
    for law in laws {
        let outcome = |sheet: &Sheet| sheet.check(law).map(|check| check.outcome);
        let (of_first, of_second) = (outcome(&kept).ok_or("on the sheet")?, outcome(&gained).ok_or("on the sheet")?);
        println!("{law:<13} (v·r)^n: {of_first}, (v·r)^n / (n·l): {of_second}");
        assert_eq!(of_first, Outcome::Pass);
        let expected = if law == "energy_eye" { Outcome::Pass } else { Outcome::Fail };
        assert_eq!(of_second, expected, "{law}");
    }
    Ok(())
}
