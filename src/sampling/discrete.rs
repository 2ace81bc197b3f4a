//! A choice among a few weighted outcomes that hands back the unused randomness.

/// Picks an index with probability weights\[i\] / Σ weights and rescales `u` to a fresh uniform in [0, 1).
///
/// Returns the index, its probability and the new uniform; None where no weight is positive and finite.
pub fn pick(weights: &[f64], u: f64) -> Option<(usize, f64, f64)> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut target = u * total;
    let mut last = None;
    for (i, &weight) in weights.iter().enumerate() {
        if weight <= 0.0 {
            continue;
        }
        last = Some((i, weight / total, (target / weight).min(1.0 - f64::EPSILON / 2.0)));
        if target < weight {
            break;
        }
        target -= weight;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picks_in_proportion_and_never_an_empty_outcome() {
        let weights = [0.25, 0.0, 0.75];
        assert_eq!(pick(&weights, 0.1), Some((0, 0.25, 0.4)));
        assert_eq!(pick(&weights, 0.25), Some((2, 0.75, 0.0)));
        assert_eq!(pick(&weights, 1.0 - f64::EPSILON / 2.0).map(|(i, ..)| i), Some(2));
        assert_eq!(pick(&[0.0, f64::NAN], 0.5), None);
    }
}
