//! Choices among weighted outcomes that hand back the unused randomness: a few by a scan, many by a table.

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

/// A choice among many weighted outcomes in constant time (Vose's alias method).
///
/// # References
/// - Walker 1977, ACM TOMS 3(3); Vose 1991, IEEE TSE 17(9)
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    /// Per column: the probability of staying in it, and where one goes else.
    columns: Vec<(f64, u32)>,
    probabilities: Vec<f64>,
}

impl AliasTable {
    /// The table of these weights, each finite and ≥ 0; None where none is positive, or there are 2³² or more.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        let sound = weights.iter().all(|&weight| weight >= 0.0) && total > 0.0 && total.is_finite();
        if !sound || weights.len() > u32::MAX as usize {
            return None;
        }
        let probabilities: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
        let mut scaled: Vec<f64> = probabilities.iter().map(|p| p * weights.len() as f64).collect();
        let mut columns: Vec<(f64, u32)> = (0..weights.len() as u32).map(|i| (1.0, i)).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..weights.len()).partition(|&i| scaled[i] < 1.0);
        while let (Some(&poor), Some(&rich)) = (small.last(), large.last()) {
            small.pop();
            columns[poor] = (scaled[poor], rich as u32);
            scaled[rich] -= 1.0 - scaled[poor];
            if scaled[rich] < 1.0 {
                large.pop();
                small.push(rich);
            }
        }
        // Rounding may leave a poor column without a rich one; an empty outcome must still never be drawn.
        let likely = (0..probabilities.len()).max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]))?;
        for column in small.into_iter().filter(|&column| probabilities[column] == 0.0) {
            columns[column] = (0.0, likely as u32);
        }
        Some(Self { columns, probabilities })
    }

    /// Picks an index with its probability and rescales `u` in [0, 1) to a fresh uniform in [0, 1).
    #[inline]
    pub fn pick(&self, u: f64) -> (usize, f64, f64) {
        let at = u * self.columns.len() as f64;
        let column = (at as usize).min(self.columns.len() - 1);
        let (stay, alias) = self.columns[column];
        let within = at - column as f64;
        let (index, fresh) =
            if within < stay { (column, within / stay) } else { (alias as usize, (within - stay) / (1.0 - stay)) };
        (index, self.probabilities[index], fresh.clamp(0.0, 1.0 - f64::EPSILON / 2.0))
    }

    /// The probability of an index.
    #[inline]
    pub fn probability(&self, index: usize) -> f64 {
        self.probabilities[index]
    }

    /// The number of outcomes.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there is no outcome, as in the default table.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }
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

    #[test]
    fn an_alias_table_gives_every_outcome_its_measure() {
        let weights = [0.1, 0.0, 3.0, 0.5, 0.4, 0.0, 1e-9];
        let table = AliasTable::new(&weights).unwrap();
        let mut measure = [0.0; 7];
        // Exact: the columns are intervals of equal length.
        for (column, &(stay, alias)) in table.columns.iter().enumerate() {
            measure[column] += stay / 7.0;
            measure[alias as usize] += (1.0 - stay) / 7.0;
        }
        for (i, weight) in weights.iter().enumerate() {
            // A few roundings of numbers up to 1.
            assert!((measure[i] - weight / 4.000000001).abs() < 1e-15, "{i}: {}", measure[i]);
            assert_eq!(table.probability(i), weight / weights.iter().sum::<f64>());
        }
        for k in 0..=1000 {
            let (index, probability, fresh) = table.pick(f64::from(k) / 1001.0);
            assert!(probability > 0.0 && weights[index] > 0.0 && (0.0..1.0).contains(&fresh));
        }
        assert!(AliasTable::new(&[0.0, 0.0]).is_none() && AliasTable::new(&[f64::NAN]).is_none());
        assert!(AliasTable::new(&[-1.0, 2.0]).is_none() && AliasTable::new(&[]).is_none());
    }
}
