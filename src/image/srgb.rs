//! The sRGB curve between linear values and those of 8- and 16-bit pictures.
//!
//! # References
//! - IEC 61966-2-1:1999

/// Where the curve leaves its straight piece, encoded and linear.
const KNEE: (f64, f64) = (0.04045, 0.0031308);

/// From an encoded value to a linear one. Total; outside [0, 1] the curve goes on.
pub fn decode(v: f64) -> f64 {
    if v <= KNEE.0 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// From a linear value to an encoded one. Inverse: [`decode`].
pub fn encode(v: f64) -> f64 {
    if v <= KNEE.1 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// d linear / d encoded at the linear value `v`: what one step of the encoded value is worth.
pub fn steepness(v: f64) -> f64 {
    if v <= KNEE.1 { 1.0 / 12.92 } else { 2.4 / 1.055 * v.powf(1.4 / 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_curve_and_its_inverse() {
        // IEC's constants join the two pieces only to 3e-8.
        for i in 0..=1000 {
            let v = f64::from(i) / 1000.0;
            assert_abs_diff_eq!(decode(encode(v)), v, epsilon = 3e-8);
        }
        assert_eq!((decode(0.0), decode(1.0)), (0.0, 1.0));
        // Middle grey of 8 bits: 0.21586 by IEC's formula.
        assert_abs_diff_eq!(decode(128.0 / 255.0), 0.215861, epsilon = 1e-6);
        let step = 1e-6;
        for v in [0.001, 0.2, 0.9] {
            let slope = (decode(encode(v) + step) - decode(encode(v) - step)) / (2.0 * step);
            // A central difference errs by step²/6 of the third derivative.
            assert_abs_diff_eq!(slope, steepness(v), epsilon = 1e-8);
        }
    }
}
