//! A BRDF of your own, put on trial in your own test: `eval` alone suffices.

use whitefurnace::prelude::*;

/// A matt ground with a bright rim, as velvet has.
#[derive(Debug)]
struct Velvet;

impl Bsdf for Velvet {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let rim = (1.0 - wo.z) * (1.0 - wi.z);
        if wo.z > 0.0 && wi.z > 0.0 { Rgb::new(0.1, 0.02, 0.05) + Rgb::grey(0.2 * rim) } else { Rgb::BLACK }
    }
}

/// In your crate, this is a `#[test]`.
fn velvet_obeys_every_law() {
    let sheet = whitefurnace::validate::suite(&Velvet);
    assert_eq!(sheet.outcome(), Outcome::Pass, "{sheet:#?}");
}

fn main() {
    velvet_obeys_every_law();
}
