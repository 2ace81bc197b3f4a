//! What a study measures the floor against: an image, with its own error where that is known.

use crate::image::Image;
use crate::math::color::Rgb;
use crate::math::sum::Neumaier;
use crate::render::film::{Film, Pixel};

/// A reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Its colours, row by row from the top.
    pub colours: Vec<Rgb>,
    /// The variance of each value; None where nothing is known of its error.
    pub variance: Option<Vec<Rgb>>,
}

impl Reference {
    /// What is on a film, with the variance of its means. None where a pixel lacks the two finite samples for that.
    pub fn of_film(film: &Film) -> Option<Self> {
        let known = film.pixels().iter().all(|pixel| pixel.n >= 2);
        known.then(|| Self {
            colours: film.pixels().iter().map(Pixel::mean).collect(),
            variance: Some(film.pixels().iter().map(Pixel::variance_of_mean).collect()),
        })
    }

    /// A picture in `width` x `height` pixels: as it is, or in the means of its square blocks, if both its sides are the same
    /// multiple of these.
    ///
    /// Its error is that of its planes `Variance.R`, `.G` and `.B`, where it has them, with what its file has rounded away.
    pub fn of_image(image: &Image, [width, height]: [usize; 2]) -> Result<Self, String> {
        let (w, h) = (image.width(), image.height());
        if !image.has_colour() {
            return Err("it has no colour".into());
        }
        // Blocks that are no squares would be those of another view.
        let side = w / width.max(1);
        if side == 0 || (width * side, height * side) != (w, h) {
            return Err(format!("it is {w} x {h}; allowed are that size and its whole parts, not {width} x {height}"));
        }
        let pixels: Vec<Rgb> = image.pixels_linear_rgb().iter().map(|c| Rgb::from(c.map(f64::from))).collect();
        if let Some(at) = pixels.iter().position(|c| !c.is_finite()) {
            return Err(format!("its pixel in column {}, row {} is not finite", at % w, at / w));
        }
        let stated = image.variance().map(|planes| {
            let rounded = |value: f64, brightest: f64| image.storage().rounding(value, brightest).powi(2) / 3.0;
            let pixel = |at: usize| {
                let colour = pixels[at];
                let of =
                    |channel: usize| f64::from(planes[channel][at]) + rounded(colour.0[channel], colour.max_channel());
                Rgb::new(of(0), of(1), of(2))
            };
            (0..pixels.len()).map(pixel).collect::<Vec<Rgb>>()
        });
        let area = (side * side) as f64;
        let block = |of: &[Rgb], at: usize| {
            let (x, y) = (at % width * side, at / width * side);
            let sum: Rgb = (0..side * side).map(|k| of[(y + k / side) * w + x + k % side]).sum();
            sum / area
        };
        let blocks = |of: &[Rgb]| (0..width * height).map(|at| block(of, at)).collect::<Vec<Rgb>>();
        let positive = |v: &Vec<Rgb>| v.iter().all(|v| v.is_finite() && v.min_channel() >= 0.0);
        Ok(Self {
            colours: blocks(&pixels),
            // The variance of a mean of m values is the mean of their variances over m.
            variance: stated.filter(positive).map(|of| blocks(&of).into_iter().map(|v| v / area).collect()),
        })
    }

    /// One pixel of it, by its place in the row of all.
    #[must_use]
    pub fn pixel(&self, at: usize) -> Self {
        let one = |of: &Vec<Rgb>| of.get(at).copied().into_iter().collect();
        Self { colours: one(&self.colours), variance: self.variance.as_ref().map(one) }
    }

    /// The same with this root mean square error in every value.
    #[must_use]
    pub fn with_error(self, error: f64) -> Self {
        let variance = Some(vec![Rgb::grey(error * error); self.colours.len()]);
        Self { variance, ..self }
    }

    /// The root of the mean of the variance over pixels and channels.
    pub fn error(&self) -> Option<f64> {
        self.variance.as_ref().map(|variance| mean(variance).sqrt())
    }

    /// The mean over pixels and channels.
    pub fn mean(&self) -> f64 {
        mean(&self.colours)
    }
}

fn mean(of: &[Rgb]) -> f64 {
    of.iter().map(|c| c.mean()).collect::<Neumaier>().value() / of.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(variance: Option<f32>) -> Image {
        let pixels: Vec<[f32; 3]> = (0..24_u8).map(|i| [f32::from(i), 1.0, 0.0]).collect();
        let mut image = Image::from_rgb(6, 4, &pixels).unwrap();
        for name in ["Variance.R", "Variance.G", "Variance.B"] {
            if let Some(v) = variance {
                image.push(name, vec![v; 24]).unwrap();
            }
        }
        image
    }

    #[test]
    fn blocks_have_the_mean_and_the_error_of_their_pixels() {
        let whole = Reference::of_image(&picture(Some(0.5)), [6, 4]).unwrap();
        assert_eq!((whole.colours[7], whole.mean()), (Rgb::new(7.0, 1.0, 0.0), 12.5 / 3.0));
        let small = Reference::of_image(&picture(Some(0.5)), [3, 2]).unwrap();
        // Pixels 2, 3, 8 and 9.
        assert_eq!(small.colours[1], Rgb::new(5.5, 1.0, 0.0));
        // Four values of variance 1/2, and roundings of single precision.
        assert!((small.error().unwrap() - 0.125_f64.sqrt()).abs() < 1e-9);
        assert_eq!(small.pixel(1).colours, [Rgb::new(5.5, 1.0, 0.0)]);
        assert_eq!(Reference::of_image(&picture(None), [6, 4]).unwrap().error(), None);
        assert_eq!(Reference::of_image(&picture(Some(f32::INFINITY)), [6, 4]).unwrap().error(), None);
        assert_eq!(whole.with_error(0.25).error(), Some(0.25));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let error = Reference::of_image(&picture(None), [4, 4]).unwrap_err();
        assert_eq!(error, "it is 6 x 4; allowed are that size and its whole parts, not 4 x 4");
        for other in [[12, 8], [3, 4], [6, 2], [0, 0], [6, 0]] {
            assert!(Reference::of_image(&picture(None), other).is_err(), "{other:?}");
        }
        let nan = Image::from_rgb(1, 1, &[[f32::NAN; 3]]).unwrap();
        assert!(Reference::of_image(&nan, [1, 1]).unwrap_err().contains("column 0, row 0"));
    }
}
