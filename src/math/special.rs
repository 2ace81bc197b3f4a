//! Special functions of cosine-power lobes, at full precision for exponents up to 10⁶.
//!
//! General-purpose libraries take these from differences of ln Γ, which lose log10(n) + 1 digits; here large
//! arguments have a series of their own.

use std::f64::consts::{PI, TAU};

/// From this exponent on the series of [`wallis`] is exact to 5e-17.
const WALLIS_SERIES_FROM: f64 = 30.0;
/// E₂, E₄, … E₁₀: Euler numbers, each over 2k.
const EULER_OVER_2K: [f64; 5] = [-1.0 / 4.0, 5.0 / 8.0, -61.0 / 12.0, 1385.0 / 16.0, -50521.0 / 20.0];

/// Wallis' integral B_n = ∫ cosⁿφ dφ over (−π/2, π/2) = √π Γ((n+1)/2) / Γ(n/2+1) = B((n+1)/2, 1/2), for n > −1.
///
/// Relative error ≤ 1e-14 for n ≤ 10⁷. Large n: the difference of two Stirling series about their common midpoint
/// N = 2n + 1, where odd powers cancel, B_n = 2 √(π/N) exp(Σ E_k / (2k Nᵏ)) over even k with Euler numbers E_k. Small
/// n: the recurrence B_n = B_{n+2} (n+2)/(n+1). NaN for n ≤ −1, where the integral does not exist.
///
/// # References
/// - DLMF 5.11.8 (ln Γ(z + h) in Bernoulli polynomials), 5.12.2
pub fn wallis(n: f64) -> f64 {
    if n <= -1.0 {
        return f64::NAN;
    }
    let (mut n, mut factor) = (n, 1.0);
    while n < WALLIS_SERIES_FROM {
        factor *= (n + 2.0) / (n + 1.0);
        n += 2.0;
    }
    let midpoint = 2.0 * n + 1.0;
    let inverse_square = 1.0 / (midpoint * midpoint);
    let exponent = EULER_OVER_2K.iter().rev().fold(0.0, |sum, term| (sum + term) * inverse_square);
    factor * 2.0 * (PI / midpoint).sqrt() * exponent.exp()
}

/// The regularised incomplete beta function I_x(a, 1/2), x in [0, 1], a ≥ 0, with `y` = 1 − x given apart.
///
/// I_x(a, 1/2) = ∫₀ˣ t^(a−1) (1−t)^(−1/2) dt / B(a, 1/2). Of sin²θ and cos²θ both are known to full precision, while
/// one less the other is not: hence two arguments. I is 1 for a = 0. Relative error ≤ 1e-13 for a ≤ 10⁶, but for the
/// conditioning of x^a itself.
///
/// # References
/// - DLMF 8.17.8 (series)
/// - DiDonato & Morris 1992, ACM TOMS 18(3) (continued fraction)
pub fn inc_beta_half(a: f64, x: f64, y: f64) -> f64 {
    if a <= 0.0 || y <= 0.0 {
        return 1.0;
    }
    if x <= 0.0 {
        return 0.0;
    }
    // √y x^a / B(a, 1/2): the power through the smaller of the two arguments, which has the digits.
    let power = if y < 0.5 { (a * (-y).ln_1p()).exp() } else { x.powf(a) };
    let prefactor = y.sqrt() * power / wallis(2.0 * a - 1.0);
    // Within about the mean of y (0.5/a) the complement's series of positive terms is short; beyond, the fraction is.
    let value = if y * (a + 2.5) < 2.0 {
        1.0 - 2.0 * prefactor * complement_series(a, y)
    } else {
        prefactor * continued_fraction(a, x, y)
    };
    value.clamp(0.0, 1.0)
}

/// ₂F₁(a + 1/2, 1; 3/2; y): every term positive.
fn complement_series(a: f64, y: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 0.0);
    while term > f64::EPSILON / 4.0 * sum {
        term *= (a + 0.5 + k) / (1.5 + k) * y;
        sum += term;
        k += 1.0;
    }
    sum
}

/// 1/(β₀ + α₁/(β₁ + α₂/(β₂ + …))) by the modified Lentz method, some tens of steps.
///
/// The even part of the better known fraction in x alone: it converges faster, and knows x near 1 through y.
fn continued_fraction(a: f64, x: f64, y: f64) -> f64 {
    const B: f64 = 0.5;
    const MAX_STEPS: u32 = 10000;
    let lambda = (a + B) * y - B;
    let beta = |n: f64| {
        n + n * (B - n) * x / (a + 2.0 * n - 1.0) + (a + n) * (lambda + 1.0 + n * (1.0 + y)) / (a + 2.0 * n + 1.0)
    };
    let first = a * (lambda + 1.0) / (a + 1.0);
    let (mut c, mut d, mut fraction) = (first, 0.0, first);
    for step in 1..=MAX_STEPS {
        let n = f64::from(step);
        let s = a + 2.0 * n - 1.0;
        let alpha = (a + n - 1.0) * (a + B + n - 1.0) * n * (B - n) * (x / s) * (x / s);
        let beta = beta(n);
        d = 1.0 / (beta + alpha * d);
        c = beta + alpha / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    1.0 / fraction
}

/// (sin 2πt, cos 2πt) for `t` in [0, 1], to 2e-16 absolute.
///
/// Turns, not radians: the reduction to an eighth of a turn is then exact, which makes it several times cheaper than
/// the general functions. The rest is Taylor's series up to x¹⁵ and x¹⁶; the next terms are below 5e-17.
#[inline]
pub fn sin_cos_turns(t: f64) -> (f64, f64) {
    let quarter = (4.0 * t + 0.5) as i64;
    let x = TAU * (t - 0.25 * quarter as f64);
    let y = x * x;
    let y2 = y * y;
    let y4 = y2 * y2;
    // Estrin's scheme: short chains of dependent products.
    let sin = (-1.0 / 6.0 + y * (1.0 / 120.0))
        + y2 * (-1.0 / 5040.0 + y * (1.0 / 362_880.0))
        + y4 * ((-1.0 / 39_916_800.0 + y * (1.0 / 6_227_020_800.0)) - y2 * (1.0 / 1_307_674_368_000.0));
    let cos = (1.0 / 24.0 - y * (1.0 / 720.0))
        + y2 * (1.0 / 40_320.0 - y * (1.0 / 3_628_800.0))
        + y4 * ((1.0 / 479_001_600.0 - y * (1.0 / 87_178_291_200.0)) + y2 * (1.0 / 20_922_789_888_000.0));
    let (sin, cos) = (x + x * y * sin, (1.0 - 0.5 * y) + y2 * cos);
    // No branches, which random turns would make wrong half of the time: an odd quarter exchanges the two, bit 1 of the
    // quarter is the sign of the sine, that of the next quarter the sign of the cosine.
    let swap = (sin.to_bits() ^ cos.to_bits()) & (quarter as u64 & 1).wrapping_neg();
    let (sin, cos) = (f64::from_bits(sin.to_bits() ^ swap), f64::from_bits(cos.to_bits() ^ swap));
    let signed = |value: f64, turn: i64| f64::from_bits(value.to_bits() ^ ((turn as u64 & 2) << 62));
    (signed(sin, quarter), signed(cos, quarter + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    /// (n, B_n) by 60-digit arithmetic from the Γ form.
    const WALLIS: [(f64, f64); 9] = [
        (-0.5, 5.244115108584239),
        (0.1, 2.9424685489207763),
        (1.0, 2.0),
        (2.5, 1.4377682816827106),
        (29.0, 0.4614745534009741),
        (30.5, 0.45017446864819567),
        (100.0, 0.2500369634803749),
        (12345.5, 0.022559361192639356),
        (1e6, 0.0025066276479740104),
    ];

    /// (a, c, I_{1−c²}(a, 1/2)) by 60-digit arithmetic, for c exactly the double.
    const INC_BETA_HALF: [(f64, f64, f64); 15] = [
        (0.05, 0.3, 0.9710556611947442),
        (0.5, 0.9, 0.2871325862574125),
        (0.5, 1e-9, 0.9999999993633802),
        (1.0, 0.5, 0.5),
        (5.5, 0.5, 0.08186423116569438),
        (5.5, 0.1, 0.7451499079905479),
        (50.0, 0.3, 0.0021883947254214514),
        (50.0, 0.02, 0.8418555277741178),
        (1234.5, 0.03, 0.13599941034010438),
        (500000.0, 0.0001, 0.9203443450950907),
        (500000.0, 0.001, 0.3173105078628536),
        (500000.5, 0.002, 0.04549999394165407),
        (500000.0, 0.01, 1.520166280827749e-23),
        (5.0, 0.999999, 7.87498687614069e-30),
        (0.001, 0.9999, 0.9901470662510801),
    ];

    #[test]
    fn wallis_agrees_with_sixty_digits() {
        for (n, expected) in WALLIS {
            // Up to 31 roundings of the recurrence and the exponential.
            assert_relative_eq!(wallis(n), expected, max_relative = 1e-14);
        }
        assert_abs_diff_eq!(wallis(0.0), PI, epsilon = 1e-14);
        assert!(wallis(-1.0).is_nan());
    }

    #[test]
    fn inc_beta_half_agrees_with_sixty_digits() {
        for (a, c, expected) in INC_BETA_HALF {
            let value = inc_beta_half(a, (1.0 - c) * (1.0 + c), c * c);
            let error = (value / expected - 1.0).abs();
            // x^a = e^−50 alone loses 50 roundings.
            assert!(error <= 1e-13, "I(a = {a}, c = {c}) = {value:e}, off by {error:e}");
        }
    }

    #[test]
    fn inc_beta_half_at_its_ends() {
        for a in [1e-3, 0.5, 7.0, 5e5] {
            assert_eq!(inc_beta_half(a, 0.0, 1.0), 0.0);
            assert_eq!(inc_beta_half(a, 1.0, 0.0), 1.0);
        }
        assert_eq!(inc_beta_half(0.0, 0.3, 0.7), 1.0);
    }

    proptest! {
        #[test]
        fn wallis_neighbours_obey_their_product(n in 0.0..1e6_f64) {
            // B_n B_{n+1} = 2π/(n+1): from the Γ form, all roots cancel.
            let product = wallis(n) * wallis(n + 1.0) * (n + 1.0);
            prop_assert!((product / (2.0 * PI) - 1.0).abs() <= 2e-14, "n = {n}: {product}");
        }

        #[test]
        fn inc_beta_half_obeys_its_recurrence(log_a in -2.0..5.7_f64, c in 0.0..1.0_f64) {
            // I_x(a, b) − I_x(a+1, b) = x^a (1−x)^b / (a B(a, b)), DLMF 8.17.20: it joins series and fraction.
            let (a, x, y) = (log_a.exp2().powf(3.33), (1.0 - c) * (1.0 + c), c * c);
            let step = c * (a * (-y).ln_1p()).exp() / (a * wallis(2.0 * a - 1.0));
            let error = inc_beta_half(a, x, y) - inc_beta_half(a + 1.0, x, y) - step;
            // Differences of numbers ≤ 1, each good to some 1e-13 where it is not small.
            prop_assert!(error.abs() <= 1e-12, "a = {a}, c = {c}: {error:e}");
        }
    }

    #[test]
    fn sines_of_turns_are_those_of_radians() {
        for i in 0..=100_000 {
            let t = f64::from(i) / 100_000.0;
            let (sin, cos) = sin_cos_turns(t);
            // The comparison itself rounds 2πt, by up to 4.5e-16.
            assert!((sin - (TAU * t).sin()).abs() < 7e-16 && (cos - (TAU * t).cos()).abs() < 7e-16, "{t}: {sin} {cos}");
            assert!((sin * sin + cos * cos - 1.0).abs() < 5e-16);
        }
        // Quarters of a turn are exact, which no multiple of the rounded π is.
        assert_eq!(
            [0.0, 0.25, 0.5, 0.75, 1.0].map(sin_cos_turns),
            [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)]
        );
    }
}
