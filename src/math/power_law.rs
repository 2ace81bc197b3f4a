//! The exponent of a power that measured points follow.

/// p of y ∝ xᵖ by least squares of logarithms, and its standard error by what these leave. None for fewer than three points, for
/// points at one x alone, and where a number is not above 0.
pub fn exponent(points: &[(f64, f64)]) -> Option<[f64; 2]> {
    let (first, _) = points.first()?;
    // By quotients, so that equal x leave exactly no spread.
    let logs = || points.iter().map(|(x, y)| ((x / first).ln(), y.ln()));
    let n = points.len() as f64;
    let (mean_x, mean_y) = (logs().map(|p| p.0).sum::<f64>() / n, logs().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = logs().map(|p| (p.0 - mean_x).powi(2)).sum();
    let slope = logs().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum::<f64>() / sxx;
    let left: f64 = logs().map(|p| (p.1 - mean_y - slope * (p.0 - mean_x)).powi(2)).sum();
    (points.len() > 2 && slope.is_finite()).then(|| [slope, (left / (n - 2.0) / sxx).sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_a_power_is_found() {
        let [slope, error] = exponent(&[4.0, 16.0, 64.0].map(|x| (x, 3.0 * x * x))).unwrap();
        assert!((slope - 2.0).abs() < 1e-14 && error < 1e-14, "{slope} {error}");
        // ln 1, ln 2 and ln 8 at 0, 1 and 2 times ln 2: slope 3/2, residuals 1/6, -1/3 and 1/6 of ln 2.
        let [slope, error] = exponent(&[(1.0, 1.0), (2.0, 2.0), (4.0, 8.0)]).unwrap();
        assert!((slope - 1.5).abs() < 1e-14 && (error - (1.0_f64 / 12.0).sqrt()).abs() < 1e-14, "{slope} {error}");
    }

    #[test]
    fn what_is_no_power_has_none() {
        assert_eq!(exponent(&[(1.0, 1.0), (2.0, 2.0)]), None);
        assert_eq!(exponent(&[(0.7, 1.0), (0.7, 2.0), (0.7, 4.0)]), None);
        assert_eq!(exponent(&[(1.0, 1.0), (2.0, 0.0), (4.0, 2.0)]), None);
        assert_eq!(exponent(&[(1.0, 1.0), (-2.0, 2.0), (4.0, 2.0)]), None);
    }
}
