//! Spectra and their colours.
//!
//! X, Y, Z = ∫ s(λ) {x̄, ȳ, z̄}(λ) dλ / ∫ ȳ dλ, then linear Rec.709. Light of a power that is the same at every wavelength has
//! Y = 1 and, since the white of Rec.709 is D65, the reddish colour (1.205, 0.948, 0.909). What reflects is seen under D65:
//! its spectrum is weighted by that illuminant, so that the colour of a constant reflectance is grey.
//! # References
//! - CIE 015:2018, Colorimetry (the standard observer of 1931 and the illuminant D65, here every 5 nm)
//! - IEC 61966-2-1:1999 (primaries and white of sRGB, the same as those of Rec.709)

use glam::{DMat3, DVec3};
use thiserror::Error;

use super::color::Rgb;

/// The first wavelength of the tables [nm].
const FIRST: f64 = 360.0;
/// The distance of their rows [nm].
const STEP: f64 = 5.0;
/// The distance of the points at which spectra are integrated [nm]: those of published data are at whole wavelengths.
const FINE: f64 = 0.5;

/// A spectrum given at some wavelengths: linear between them, 0 outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    wavelengths: Vec<f64>,
    values: Vec<f64>,
}

/// Why samples make no spectrum.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SpectrumError {
    /// There must be two samples at least.
    #[error("{0} samples; allowed are two or more")]
    TooFew(usize),
    /// Wavelengths must increase.
    #[error("the wavelength {0} nm does not come after the one before; allowed are finite, increasing wavelengths")]
    Order(f64),
    /// A value is NaN or infinite.
    #[error("the value {value} at {wavelength} nm; allowed are finite values")]
    NotFinite {
        /// Where [nm].
        wavelength: f64,
        /// The value.
        value: f64,
    },
}

impl Spectrum {
    /// The spectrum through these pairs of a wavelength [nm] and a value.
    pub fn new(samples: impl IntoIterator<Item = (f64, f64)>) -> Result<Self, SpectrumError> {
        let (wavelengths, values): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        if wavelengths.len() < 2 {
            return Err(SpectrumError::TooFew(wavelengths.len()));
        }
        let mut before = f64::NEG_INFINITY;
        for (&wavelength, &value) in wavelengths.iter().zip(&values) {
            if !(wavelength.is_finite() && wavelength > before) {
                return Err(SpectrumError::Order(wavelength));
            }
            if !value.is_finite() {
                return Err(SpectrumError::NotFinite { wavelength, value });
            }
            before = wavelength;
        }
        Ok(Self { wavelengths, values })
    }

    /// The value at a wavelength [nm].
    pub fn at(&self, wavelength: f64) -> f64 {
        let above = self.wavelengths.partition_point(|&w| w <= wavelength);
        let Some(below) = above.checked_sub(1) else { return 0.0 };
        let Some(&next) = self.wavelengths.get(above) else {
            return if self.wavelengths[below] == wavelength { self.values[below] } else { 0.0 };
        };
        let t = (wavelength - self.wavelengths[below]) / (next - self.wavelengths[below]);
        self.values[below] * (1.0 - t) + self.values[above] * t
    }

    /// The colour of light with this spectrum; channels are negative where it is out of gamut.
    pub fn emitted(&self) -> Rgb {
        let seen = integrate(|wavelength| self.at(wavelength), |_| 1.0);
        let whole = integrate(|_| 1.0, |_| 1.0).y;
        Rgb(rgb_from_xyz() * (seen / whole))
    }

    /// The colour under D65 of what has this reflectance, or any other property weighted alike.
    pub fn reflected(&self) -> Rgb {
        let seen = rgb_from_xyz() * integrate(|wavelength| self.at(wavelength), illuminant);
        // The white of the tables, not that of the standard, which is rounded: a constant must be grey.
        Rgb(seen / (rgb_from_xyz() * integrate(|_| 1.0, illuminant)))
    }
}

/// The colour of light whose power is `value` at every wavelength.
pub fn equal_energy(value: f64) -> Rgb {
    Rgb(rgb_from_xyz() * DVec3::splat(value))
}

/// ∫ spectrum × weight × {x̄, ȳ, z̄} dλ, by midpoints.
fn integrate(spectrum: impl Fn(f64) -> f64, weight: impl Fn(f64) -> f64) -> DVec3 {
    let count = ((TABLE.len() - 1) as f64 * STEP / FINE) as usize;
    let at = |i: usize| {
        let wavelength = FIRST + (i as f64 + 0.5) * FINE;
        let [x, y, z, _] = row(wavelength);
        DVec3::new(x, y, z) * (spectrum(wavelength) * weight(wavelength))
    };
    (0..count).map(at).sum::<DVec3>() * FINE
}

fn illuminant(wavelength: f64) -> f64 {
    row(wavelength)[3]
}

/// x̄, ȳ, z̄ and D65 at a wavelength within the table.
fn row(wavelength: f64) -> [f64; 4] {
    let at = ((wavelength - FIRST) / STEP).clamp(0.0, (TABLE.len() - 1) as f64);
    let below = (at as usize).min(TABLE.len() - 2);
    let t = at - below as f64;
    std::array::from_fn(|c| TABLE[below][c] * (1.0 - t) + TABLE[below + 1][c] * t)
}

/// From XYZ to linear Rec.709, from the chromaticities of its primaries and of its white.
fn rgb_from_xyz() -> DMat3 {
    let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
    let brightness = primaries.inverse() * xyz(0.3127, 0.3290);
    (primaries * DMat3::from_diagonal(brightness)).inverse()
}

/// x̄, ȳ, z̄ of the standard observer, and the illuminant D65 (100 at 560 nm).
#[rustfmt::skip]
const TABLE: [[f64; 4]; 95] = [
    [1.299e-4, 3.917e-6, 6.061e-4, 46.64],
    [2.321e-4, 6.965e-6, 0.001086, 49.36],
    [4.149e-4, 1.239e-5, 0.001946, 52.09],
    [7.416e-4, 2.202e-5, 0.003486, 51.03],
    [0.001368, 3.9e-5, 0.00645, 49.98],
    [0.002236, 6.4e-5, 0.01055, 52.31],
    [0.004243, 1.2e-4, 0.02005, 54.65],
    [0.00765, 2.17e-4, 0.03621, 68.7],
    [0.01431, 3.96e-4, 0.06785, 82.75],
    [0.02319, 6.4e-4, 0.1102, 87.12],
    [0.04351, 0.00121, 0.2074, 91.49],
    [0.07763, 0.00218, 0.3713, 92.46],
    [0.1344, 0.004, 0.6456, 93.43],
    [0.2148, 0.0073, 1.039, 90.06],
    [0.2839, 0.0116, 1.386, 86.68],
    [0.3285, 0.01684, 1.623, 95.77],
    [0.3483, 0.023, 1.747, 104.9],
    [0.3481, 0.0298, 1.783, 110.9],
    [0.3362, 0.038, 1.772, 117.0],
    [0.3187, 0.048, 1.744, 117.4],
    [0.2908, 0.06, 1.669, 117.8],
    [0.2511, 0.0739, 1.528, 116.3],
    [0.1954, 0.09098, 1.288, 114.9],
    [0.1421, 0.1126, 1.042, 115.4],
    [0.09564, 0.139, 0.813, 115.9],
    [0.05795, 0.1693, 0.6162, 112.4],
    [0.03201, 0.208, 0.4652, 108.8],
    [0.0147, 0.2586, 0.3533, 109.1],
    [0.0049, 0.323, 0.272, 109.4],
    [0.0024, 0.4073, 0.2123, 108.6],
    [0.0093, 0.503, 0.1582, 107.8],
    [0.0291, 0.6082, 0.1117, 106.3],
    [0.06327, 0.71, 0.07825, 104.8],
    [0.1096, 0.7932, 0.05725, 106.2],
    [0.1655, 0.862, 0.04216, 107.7],
    [0.2257, 0.9149, 0.02984, 106.0],
    [0.2904, 0.954, 0.0203, 104.4],
    [0.3597, 0.9803, 0.0134, 104.2],
    [0.4334, 0.995, 0.00875, 104.0],
    [0.5121, 1.0, 0.00575, 102.0],
    [0.5945, 0.995, 0.0039, 100.0],
    [0.6784, 0.9786, 0.00275, 98.17],
    [0.7621, 0.952, 0.0021, 96.33],
    [0.8425, 0.9154, 0.0018, 96.06],
    [0.9163, 0.87, 0.00165, 95.79],
    [0.9786, 0.8163, 0.0014, 92.24],
    [1.026, 0.757, 0.0011, 88.69],
    [1.057, 0.6949, 0.001, 89.35],
    [1.062, 0.631, 8e-4, 90.01],
    [1.046, 0.5668, 6e-4, 89.8],
    [1.003, 0.503, 3.4e-4, 89.6],
    [0.9384, 0.4412, 2.4e-4, 88.65],
    [0.8544, 0.381, 1.9e-4, 87.7],
    [0.7514, 0.321, 1e-4, 85.49],
    [0.6424, 0.265, 5e-5, 83.29],
    [0.5419, 0.217, 3e-5, 83.49],
    [0.4479, 0.175, 2e-5, 83.7],
    [0.3608, 0.1382, 1e-5, 81.86],
    [0.2835, 0.107, 0.0, 80.03],
    [0.2187, 0.0816, 0.0, 80.12],
    [0.1649, 0.061, 0.0, 80.21],
    [0.1212, 0.04458, 0.0, 81.25],
    [0.0874, 0.032, 0.0, 82.28],
    [0.0636, 0.0232, 0.0, 80.28],
    [0.04677, 0.017, 0.0, 78.28],
    [0.0329, 0.01192, 0.0, 74.0],
    [0.0227, 0.00821, 0.0, 69.72],
    [0.01584, 0.005723, 0.0, 70.67],
    [0.01136, 0.004102, 0.0, 71.61],
    [0.008111, 0.002929, 0.0, 72.98],
    [0.00579, 0.002091, 0.0, 74.35],
    [0.004109, 0.001484, 0.0, 67.98],
    [0.002899, 0.001047, 0.0, 61.6],
    [0.002049, 7.4e-4, 0.0, 65.74],
    [0.00144, 5.2e-4, 0.0, 69.89],
    [9.999e-4, 3.611e-4, 0.0, 72.49],
    [6.901e-4, 2.492e-4, 0.0, 75.09],
    [4.76e-4, 1.719e-4, 0.0, 69.34],
    [3.323e-4, 1.2e-4, 0.0, 63.59],
    [2.348e-4, 8.48e-5, 0.0, 55.01],
    [1.662e-4, 6e-5, 0.0, 46.42],
    [1.174e-4, 4.24e-5, 0.0, 56.61],
    [8.308e-5, 3e-5, 0.0, 66.81],
    [5.871e-5, 2.12e-5, 0.0, 65.09],
    [4.151e-5, 1.499e-5, 0.0, 63.38],
    [2.935e-5, 1.06e-5, 0.0, 63.84],
    [2.067e-5, 7.466e-6, 0.0, 64.3],
    [1.456e-5, 5.258e-6, 0.0, 61.88],
    [1.025e-5, 3.703e-6, 0.0, 59.45],
    [7.221e-6, 2.608e-6, 0.0, 55.71],
    [5.086e-6, 1.837e-6, 0.0, 51.96],
    [3.582e-6, 1.293e-6, 0.0, 54.7],
    [2.523e-6, 9.109e-7, 0.0, 57.44],
    [1.777e-6, 6.415e-7, 0.0, 58.88],
    [1.251e-6, 4.518e-7, 0.0, 60.31],
];

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn list(text: &str) -> Spectrum {
        let pair = |word: &str| {
            let (w, v) = word.split_once(':').unwrap();
            (w.trim().parse().unwrap(), v.trim().parse().unwrap())
        };
        Spectrum::new(text.split(',').map(pair)).unwrap()
    }

    #[test]
    fn constants_are_white_under_d65_and_reddish_as_light() {
        let flat = list("300:0.5, 900:0.5");
        assert_abs_diff_eq!(flat.reflected(), Rgb::grey(0.5), epsilon = 1e-15);
        // 2e-4: the sums of the three functions differ by so much, every 5 nm.
        assert_abs_diff_eq!(flat.emitted(), equal_energy(0.5), epsilon = 2e-4);
        // x = y = 1/3 in the published matrix of sRGB, which has four digits.
        let published = Rgb::new(3.2406 - 1.5372 - 0.4986, -0.9689 + 1.8758 + 0.0415, 0.0557 - 0.2040 + 1.0570);
        assert_abs_diff_eq!(equal_energy(1.0), published, epsilon = 3e-4);
    }

    #[test]
    fn the_white_of_the_table_is_d65() {
        let white = integrate(|_| 1.0, illuminant);
        let sum = white.x + white.y + white.z;
        // Published: x = 0.31272, y = 0.32903. Lines between rows 5 nm apart cut the peaks of the observer: 3e-5.
        assert_abs_diff_eq!(white.x / sum, 0.31272, epsilon = 5e-5);
        assert_abs_diff_eq!(white.y / sum, 0.32903, epsilon = 5e-5);
    }

    #[test]
    fn colours_agree_with_mitsuba() {
        // Mitsuba 3.9.1, scalar_rgb. Light agrees to the digits of its tables; for reflectances its sum over 1000 points is
        // 0.1 % low, as its value for a constant, 0.999, shows.
        let light = list("400:0, 500:8, 600:15.6, 700:18.4").emitted();
        for (ours, theirs) in light.to_array().into_iter().zip([20.7108, 10.8546, 2.77115]) {
            assert!((ours / theirs - 1.0).abs() <= 3e-4, "{ours} {theirs}");
        }
        let grey = list("400:0.78, 500:0.78, 600:0.78, 700:0.78").reflected();
        assert_abs_diff_eq!(grey * 0.999, Rgb::new(0.776367, 0.77981, 0.776029), epsilon = 3e-4);
        let eta = list("300:1.8, 400:1.65, 500:0.9, 600:0.2, 700:0.16, 800:0.18").reflected();
        assert_abs_diff_eq!(eta * 0.999, Rgb::new(0.0452341, 0.585709, 1.33692), epsilon = 5e-4);
    }

    #[test]
    fn between_samples_linear_and_outside_dark() {
        let ramp = list("400:1, 500:2");
        assert_eq!([399.0, 400.0, 450.0, 500.0, 501.0].map(|w| ramp.at(w)), [0.0, 1.0, 1.5, 2.0, 0.0]);
    }

    #[test]
    fn bad_samples_are_refused() {
        assert!(Spectrum::new([(1.0, 1.0)]).is_err() && Spectrum::new([(2.0, 1.0), (2.0, 1.0)]).is_err());
        assert!(Spectrum::new([(1.0, 1.0), (f64::NAN, 1.0)]).is_err());
        assert!(Spectrum::new([(1.0, 1.0), (2.0, f64::INFINITY)]).is_err());
    }
}
