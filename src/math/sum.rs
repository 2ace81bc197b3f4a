//! Sums that keep their digits: Neumaier's compensated sum and one-pass central moments.

/// A compensated sum: the error stays at one rounding of the result, whatever the number of terms.
///
/// # References
/// - Neumaier 1974, ZAMM 54, the improved Kahan-Babuška algorithm
#[derive(Clone, Copy, Debug, Default)]
pub struct Neumaier {
    sum: f64,
    compensation: f64,
}

impl Neumaier {
    /// Adds one term.
    pub fn add(&mut self, term: f64) {
        let next = self.sum + term;
        self.compensation +=
            if self.sum.abs() >= term.abs() { (self.sum - next) + term } else { (term - next) + self.sum };
        self.sum = next;
    }

    /// The sum so far.
    pub fn value(&self) -> f64 {
        self.sum + self.compensation
    }
}

impl FromIterator<f64> for Neumaier {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::default();
        for term in terms {
            sum.add(term);
        }
        sum
    }
}

/// Count, mean and central moments up to the fourth, in one pass; two of them merge exactly.
///
/// # References
/// - Pébay 2008, Sandia report SAND2008-6212 (update and pairwise merge of M2, M3, M4)
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    n: u64,
    mean: f64,
    m2: f64,
    m3: f64,
    m4: f64,
    max: f64,
}

impl Moments {
    /// Adds one value.
    pub fn add(&mut self, x: f64) {
        self.max = if self.n == 0 { x } else { self.max.max(x) };
        self.n += 1;
        let n = self.n as f64;
        let delta = x - self.mean;
        let step = delta / n;
        let term = delta * step * (n - 1.0);
        self.mean += step;
        self.m4 += term * step * step * (n * n - 3.0 * n + 3.0) + 6.0 * step * step * self.m2 - 4.0 * step * self.m3;
        self.m3 += term * step * (n - 2.0) - 3.0 * step * self.m2;
        self.m2 += term;
    }

    /// The moments of both sets of values together.
    #[must_use]
    pub fn merge(&self, other: &Self) -> Self {
        if self.n == 0 {
            return *other;
        }
        if other.n == 0 {
            return *self;
        }
        let (a, b) = (self.n as f64, other.n as f64);
        let n = a + b;
        let d = other.mean - self.mean;
        let (d2, ab) = (d * d, a * b);
        Self {
            n: self.n + other.n,
            mean: self.mean + d * b / n,
            m2: self.m2 + other.m2 + d2 * ab / n,
            m3: self.m3 + other.m3 + d2 * d * ab * (a - b) / (n * n) + 3.0 * d * (a * other.m2 - b * self.m2) / n,
            m4: self.m4
                + other.m4
                + d2 * d2 * ab * (a * a - ab + b * b) / (n * n * n)
                + 6.0 * d2 * (a * a * other.m2 + b * b * self.m2) / (n * n)
                + 4.0 * d * (a * other.m3 - b * self.m3) / n,
            max: self.max.max(other.max),
        }
    }

    /// How many values were added.
    pub fn count(&self) -> u64 {
        self.n
    }

    /// Their mean; 0 for none.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The largest value added; 0 for none.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The unbiased variance M2 / (n − 1); infinite for fewer than two values.
    pub fn variance(&self) -> f64 {
        if self.n < 2 { f64::INFINITY } else { self.m2 / (self.n - 1) as f64 }
    }

    /// The standard error of the mean, sqrt(variance / n).
    pub fn std_err(&self) -> f64 {
        if self.n < 2 { f64::INFINITY } else { (self.variance() / self.n as f64).sqrt() }
    }

    /// Excess kurtosis n M4 / M2² − 3: 0 for a Gaussian, and 0 where every value is the same.
    pub fn excess_kurtosis(&self) -> f64 {
        if self.m2 > 0.0 { self.n as f64 * self.m4 / (self.m2 * self.m2) - 3.0 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn neumaier_keeps_what_a_plain_sum_loses() {
        let terms = [1.0, 1e100, 1.0, -1e100];
        assert_eq!(terms.iter().sum::<f64>(), 0.0, "the plain sum must fail, or this test shows nothing");
        assert_eq!(Neumaier::from_iter(terms).value(), 2.0);
    }

    #[test]
    fn moments_of_a_fair_die() {
        let mut m = Moments::default();
        for _ in 0..1000 {
            for face in 1..=6 {
                m.add(f64::from(face));
            }
        }
        assert_relative_eq!(m.mean(), 3.5, max_relative = 1e-13);
        // 35/12, with the n − 1 correction of 6000 throws.
        assert_relative_eq!(m.variance(), 35.0 / 12.0 * 6000.0 / 5999.0, max_relative = 1e-12);
        // Kurtosis of a die: (3/5)(3·36 − 7)/(36 − 1) = 303/175.
        assert_relative_eq!(m.excess_kurtosis(), 303.0 / 175.0 - 3.0, max_relative = 1e-10);
    }

    #[test]
    fn merging_equals_adding() {
        let values: Vec<f64> = (0..100).map(|i| (f64::from(i) * 0.7).sin() + 5.0).collect();
        let fill = |v: &[f64]| {
            let mut m = Moments::default();
            for &x in v {
                m.add(x);
            }
            m
        };
        let (whole, merged) = (fill(&values), fill(&values[..37]).merge(&fill(&values[37..])));
        assert_relative_eq!(whole.mean(), merged.mean(), max_relative = 1e-14);
        assert_relative_eq!(whole.variance(), merged.variance(), max_relative = 1e-12);
        assert_relative_eq!(whole.excess_kurtosis(), merged.excess_kurtosis(), max_relative = 1e-10);
    }
}
