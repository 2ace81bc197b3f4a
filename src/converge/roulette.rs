//! Russian roulette in a furnace: an estimator whose variance is known, finite or not.
//!
//! Every reflection brings albedo ρ of the light. Roulette lets a path go on with probability q and divides it by that, so
//! that a path of K reflections brings X = w + w² + … + w^K with w = ρ/q, and P(K ≥ k) = q^k. Then
//!
//! E\[X\] = ρ / (1 − ρ),   Var\[X\] = ρ² (1 − q) / ((1 − ρ)² (q − ρ²))  for q > ρ², else ∞
//!
//! since E\[X²\] is a geometric series of ratio w² q = ρ²/q. The fourth moment, which says how well a sample tells the
//! variance, has the ratio w⁴ q = ρ⁴/q³: it is finite for q > ρ^(4/3) alone.
//! # References
//! - Arvo & Kirk 1990, Particle transport and image synthesis, SIGGRAPH (roulette; the variance follows as above)

use super::Estimator;
use super::variance::moments;
use crate::bsdf::ParamError;
use crate::math::sum::Moments;
use crate::sampling::sampler::Sampler;

/// A furnace of albedo ρ, in which paths go on with probability q.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Furnace {
    rho: f64,
    q: f64,
}

impl Furnace {
    /// `rho` and `q` in (0, 1).
    pub fn new(rho: f64, q: f64) -> Result<Self, ParamError> {
        for (name, value) in [("rho", rho), ("q", q)] {
            if !(value > 0.0 && value < 1.0) {
                return Err(ParamError::new("roulette", name, value, "a number in (0, 1)"));
            }
        }
        Ok(Self { rho, q })
    }

    /// The probability with which a path goes on.
    pub fn survival(&self) -> f64 {
        self.q
    }

    /// ρ / (1 − ρ).
    pub fn mean(&self) -> f64 {
        self.rho / (1.0 - self.rho)
    }

    /// Of one path; infinite for q ≤ ρ².
    pub fn variance(&self) -> f64 {
        let Self { rho, q } = *self;
        if q <= rho * rho {
            return f64::INFINITY;
        }
        rho * rho * (1.0 - q) / ((1.0 - rho).powi(2) * (q - rho * rho))
    }

    /// Whether the variance of samples has an error that can be known from them: q > ρ^(4/3).
    pub fn has_fourth_moment(&self) -> bool {
        self.q > self.rho.powf(4.0 / 3.0)
    }

    /// The light of one path.
    pub fn draw(&self, sampler: &mut dyn Sampler) -> f64 {
        let (mut sum, mut weight) = (0.0, 1.0);
        while sampler.next_1d() < self.q {
            weight *= self.rho / self.q;
            sum += weight;
        }
        sum
    }

    /// The same as an estimator of [`mean`](Self::mean).
    pub fn estimator(self) -> Estimator<'static> {
        let sigma = Some(self.variance().sqrt()).filter(|sigma| sigma.is_finite());
        Estimator { name: "roulette", draw: Box::new(move |sampler| self.draw(sampler)), sigma }
    }

    /// The moments of `n` paths; `number` tells one measurement from another under the same seed.
    pub fn measure(&self, n: u64, seed: u64, number: u64) -> Moments {
        moments(n, seed, number, &|sampler| self.draw(sampler))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::converge::variance::variance_std_err;

    #[test]
    fn the_closed_form_is_that_of_the_series() {
        for (rho, q) in [(0.5, 0.4), (0.5, 0.5), (0.9, 0.95), (0.3, 0.9)] {
            let furnace = Furnace::new(rho, q).unwrap();
            let w: f64 = rho / q;
            let (mut mean, mut square, mut sum) = (0.0, 0.0, 0.0);
            // A path of exactly k reflections has probability q^k (1 − q).
            for k in 1..1500 {
                sum += w.powi(k);
                mean += q.powi(k) * (1.0 - q) * sum;
                square += q.powi(k) * (1.0 - q) * sum * sum;
            }
            assert!((mean / furnace.mean() - 1.0).abs() < 1e-10, "1500 roundings: ρ {rho}, q {q}");
            assert!(
                ((square - mean * mean) / furnace.variance() - 1.0).abs() < 1e-9,
                "and a difference: ρ {rho}, q {q}"
            );
        }
        // Survival with the albedo: ρ / (1 − ρ)².
        assert!((Furnace::new(0.5, 0.5).unwrap().variance() - 2.0).abs() < 1e-14);
    }

    #[test]
    fn a_survival_of_rho_squared_or_less_has_no_variance() {
        assert!([0.5, 0.81].iter().all(|&q| Furnace::new(0.9, q).unwrap().variance().is_infinite()));
        assert!(Furnace::new(0.9, 0.8101).unwrap().variance().is_finite());
        assert!(Furnace::new(0.9, 0.6).unwrap().estimator().sigma.is_none());
        assert!(
            Furnace::new(1.0, 0.5).is_err() && Furnace::new(0.5, 0.0).is_err() && Furnace::new(f64::NAN, 0.5).is_err()
        );
    }

    #[test]
    fn samples_have_the_variance_of_the_closed_form() {
        for (i, (rho, q)) in [(0.5, 0.45), (0.5, 0.7), (0.9, 0.95)].into_iter().enumerate() {
            let furnace = Furnace::new(rho, q).unwrap();
            let found = furnace.measure(200_000, 1, i as u64);
            assert!(furnace.has_fourth_moment());
            let z = (found.variance() - furnace.variance()) / variance_std_err(&found);
            // One in 16 000 for each.
            assert!(z.abs() < 4.0, "ρ {rho}, q {q}: {} against {}, z = {z}", found.variance(), furnace.variance());
            // Twins: paths that are not weighed up, or too much.
            for twin in [1.0, 1.02 * rho / q] {
                let found = moments(200_000, 1, 10 + i as u64, &|sampler| {
                    let (mut sum, mut weight) = (0.0, 1.0);
                    while sampler.next_1d() < q {
                        weight *= twin;
                        sum += weight;
                    }
                    sum
                });
                let z = (found.variance() - furnace.variance()) / variance_std_err(&found);
                assert!(z.abs() > 4.0, "ρ {rho}, q {q}: a weight of {twin} is not seen, z = {z}");
            }
        }
    }
}
