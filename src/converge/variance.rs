//! The variance of an estimator from independent values of it, and how well they tell it.

use rayon::prelude::*;

use crate::math::sum::Moments;
use crate::sampling::sampler::{Independent, Sampler};

/// Values that one unit of work draws: the sums do not depend on the number of threads.
const UNIT: u64 = 4096;

/// The moments of `n` independent values of `draw`; `number` tells one measurement from another under the same seed.
pub fn moments(n: u64, seed: u64, number: u64, draw: &(dyn Fn(&mut dyn Sampler) -> f64 + Sync)) -> Moments {
    let unit = |unit: u64| {
        let mut moments = Moments::default();
        for sample in unit * UNIT..((unit + 1) * UNIT).min(n) {
            moments.add(draw(&mut Independent::at(seed, number, sample)));
        }
        moments
    };
    let units: Vec<Moments> = (0..n.div_ceil(UNIT)).into_par_iter().map(unit).collect();
    units.iter().fold(Moments::default(), |all, one| all.merge(one))
}

/// The standard error of a variance that these values gave: √((κ + 2) / n) of it, with κ their excess kurtosis. It means
/// nothing where the fourth moment is infinite.
pub fn variance_std_err(moments: &Moments) -> f64 {
    moments.variance() * ((moments.excess_kurtosis() + 2.0).max(0.0) / moments.count() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uniform_number_has_its_variance_on_any_number_of_threads() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| moments(10_001, 1, 2, &|sampler| sampler.next_1d()))
        };
        let found = run(1);
        assert_eq!(found, run(3));
        assert_eq!(found.count(), 10_001);
        // A uniform number has variance 1/12 and kurtosis 9/5, so that the error is √(4/5 / n) of it.
        assert!((variance_std_err(&found) * 12.0 / (0.8_f64 / 10_001.0).sqrt() - 1.0).abs() < 0.05);
        assert!((found.variance() - 1.0 / 12.0).abs() < 4.0 * variance_std_err(&found), "1 in 16 000 seeds");
    }
}
