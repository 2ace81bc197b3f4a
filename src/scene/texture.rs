//! Colours that vary over a surface.

use std::sync::Arc;

use glam::{DAffine2, DVec2};

use crate::math::color::Rgb;

/// A linear colour as a function of the texture coordinates.
#[derive(Clone, Debug)]
pub enum Texture {
    /// The same everywhere.
    Constant(Rgb),
    /// A picture.
    Bitmap(Bitmap),
    /// Squares of two colours, half a unit wide: `first` where the halves of u and v agree.
    Checkerboard {
        /// The colour at (0, 0).
        first: Rgb,
        /// The other.
        second: Rgb,
        /// Applied to the texture coordinates.
        to_uv: DAffine2,
    },
    /// The interpolated colour of the vertices; white where there is none.
    VertexColor,
}

/// A picture over the unit square; (0, 0) is its lower left corner, v runs upwards.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// Linear values, rows from the top.
    pub pixels: Arc<Vec<[f32; 3]>>,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Applied to the texture coordinates.
    pub to_uv: DAffine2,
    /// What lies outside the unit square.
    pub wrap: Wrap,
    /// Whether values between the centres of pixels are interpolated.
    pub bilinear: bool,
    /// Multiplies the values.
    pub scale: Rgb,
}

/// What a picture shows outside the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It starts again.
    #[default]
    Repeat,
    /// It starts again, mirrored.
    Mirror,
    /// Its edge goes on.
    Clamp,
}

impl Texture {
    /// The colour at `uv`; `vertex_color` is that of the mesh.
    pub fn at(&self, uv: DVec2, vertex_color: Rgb) -> Rgb {
        match self {
            Self::Constant(colour) => *colour,
            Self::Bitmap(bitmap) => bitmap.at(uv),
            Self::Checkerboard { first, second, to_uv } => {
                let half = |x: f64| x - x.floor() > 0.5;
                let uv = to_uv.transform_point2(uv);
                if half(uv.x) == half(uv.y) { *first } else { *second }
            }
            Self::VertexColor => vertex_color,
        }
    }

    /// A bound on every channel.
    pub fn max_channel(&self) -> f64 {
        match self {
            Self::Constant(colour) => colour.max_channel(),
            Self::Bitmap(bitmap) => {
                let scale = bitmap.scale.to_array();
                let largest = |p: &[f32; 3]| (0..3).map(|c| f64::from(p[c]) * scale[c]).fold(0.0, f64::max);
                bitmap.pixels.iter().map(largest).fold(0.0, f64::max)
            }
            Self::Checkerboard { first, second, .. } => first.max_channel().max(second.max_channel()),
            Self::VertexColor => 1.0,
        }
    }
}

impl From<Rgb> for Texture {
    fn from(colour: Rgb) -> Self {
        Self::Constant(colour)
    }
}

impl Bitmap {
    /// The interpolated colour at `uv`.
    pub fn at(&self, uv: DVec2) -> Rgb {
        let uv = self.to_uv.transform_point2(uv);
        // Rows run from the top.
        let x = uv.x * self.width as f64;
        let y = (1.0 - uv.y) * self.height as f64;
        if !self.bilinear {
            return self.pixel(x.floor(), y.floor());
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let row = |y: f64| self.pixel(x0, y) * (1.0 - fx) + self.pixel(x0 + 1.0, y) * fx;
        row(y0) * (1.0 - fy) + row(y0 + 1.0) * fy
    }

    fn pixel(&self, x: f64, y: f64) -> Rgb {
        let wrap = |at: f64, size: usize| {
            let n = size as f64;
            let inside = match self.wrap {
                Wrap::Repeat => at.rem_euclid(n),
                Wrap::Mirror => {
                    let turn = at.rem_euclid(2.0 * n);
                    if turn < n { turn } else { 2.0 * n - 1.0 - turn }
                }
                Wrap::Clamp => at,
            };
            // NaN becomes 0.
            (inside.clamp(0.0, n - 1.0) as usize).min(size - 1)
        };
        let at = wrap(y, self.height) * self.width + wrap(x, self.width);
        let [r, g, b] = self.pixels[at].map(f64::from);
        Rgb::new(r, g, b) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_by_two() -> Bitmap {
        Bitmap {
            pixels: Arc::new(vec![[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3]]),
            width: 2,
            height: 2,
            to_uv: DAffine2::IDENTITY,
            wrap: Wrap::Repeat,
            bilinear: true,
            scale: Rgb::WHITE,
        }
    }

    #[test]
    fn centres_of_pixels_are_exact_and_v_runs_upwards() {
        let bitmap = two_by_two();
        let at = |u, v| bitmap.at(DVec2::new(u, v)).0.x;
        assert_eq!([at(0.25, 0.75), at(0.75, 0.75), at(0.25, 0.25), at(0.75, 0.25)], [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(at(0.5, 0.5), 1.5);
    }

    #[test]
    fn outside_follows_the_wrap_mode() {
        let at = |wrap, u: f64| Bitmap { wrap, bilinear: false, ..two_by_two() }.at(DVec2::new(u, 0.75)).0.x;
        assert_eq!([at(Wrap::Repeat, 1.25), at(Wrap::Mirror, 1.25), at(Wrap::Clamp, 1.25)], [0.0, 1.0, 1.0]);
        assert_eq!([at(Wrap::Repeat, -0.25), at(Wrap::Mirror, -0.25), at(Wrap::Clamp, -0.25)], [1.0, 0.0, 0.0]);
        assert_eq!(at(Wrap::Repeat, f64::NAN), 0.0);
    }
}
