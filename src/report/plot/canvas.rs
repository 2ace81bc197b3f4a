//! What plotters draws on: an SVG or a [`Raster`], with one measure of text.

use std::io;

use glam::DVec2;
use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingErrorKind, FontTransform};

use super::font::{X_HEIGHT, text_width};
use super::raster::{Raster, Turn};

/// Pixels of a raster for one unit of the drawing: half as many make lines of one pixel of the SVG two pixels wide, as a
/// screen of double density shows them.
pub(super) const DENSITY: f64 = 0.5;

/// plotters means by the size of a font 1.24 ems.
const SIZE_OF_EM: f64 = 1.24;

/// Where a figure is drawn.
pub(super) enum Canvas<'a> {
    Svg(SVGBackend<'a>),
    Raster { raster: &'a mut Raster, size: (u32, u32) },
}

type Done = Result<(), DrawingErrorKind<io::Error>>;

fn rgb(colour: BackendColor) -> [u8; 3] {
    colour.rgb.into()
}

fn pixel(at: BackendCoord) -> DVec2 {
    DENSITY * DVec2::new(at.0.into(), at.1.into())
}

fn pixels(path: impl IntoIterator<Item = BackendCoord>) -> Vec<DVec2> {
    path.into_iter().map(pixel).collect()
}

impl DrawingBackend for Canvas<'_> {
    type ErrorType = io::Error;

    fn get_size(&self) -> (u32, u32) {
        match self {
            Self::Svg(svg) => svg.get_size(),
            Self::Raster { size, .. } => *size,
        }
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        match self {
            Self::Svg(svg) => svg.present(),
            Self::Raster { .. } => Ok(()),
        }
    }

    fn draw_pixel(&mut self, at: BackendCoord, colour: BackendColor) -> Done {
        self.draw_rect(at, (at.0 + 1, at.1 + 1), &colour, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, a: BackendCoord, b: BackendCoord, style: &S, fill: bool) -> Done {
        if !fill {
            // As a path, since the SVG's rectangle forgets the width of its line.
            return self.draw_path([a, (b.0, a.1), b, (a.0, b.1), a], style);
        }
        match self {
            Self::Svg(svg) => svg.draw_rect(a, b, style, true),
            Self::Raster { raster, .. } => {
                // Whole pixels, so that neighbours show no seam.
                let ([a, b], colour) = ([pixel(a).round(), pixel(b).round()], style.color());
                let corners = [a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)];
                raster.polygon(&corners, rgb(colour), colour.alpha);
                Ok(())
            }
        }
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        match self {
            Self::Svg(svg) => svg.draw_path(path, style),
            Self::Raster { raster, .. } => {
                let width = f64::from(style.stroke_width()) * DENSITY;
                raster.stroke(&pixels(path), width, rgb(style.color()), style.color().alpha);
                Ok(())
            }
        }
    }

    fn draw_circle<S: BackendStyle>(&mut self, at: BackendCoord, radius: u32, style: &S, fill: bool) -> Done {
        match self {
            Self::Svg(svg) => svg.draw_circle(at, radius, style, fill),
            Self::Raster { raster, .. } if fill => {
                raster.disc(pixel(at), f64::from(radius) * DENSITY, rgb(style.color()), style.color().alpha);
                Ok(())
            }
            Self::Raster { .. } => {
                let corner = |step: i32| {
                    let (sin, cos) = (f64::from(step) * std::f64::consts::TAU / 64.0).sin_cos();
                    let r = f64::from(radius);
                    (at.0 + (r * cos).round() as i32, at.1 + (r * sin).round() as i32)
                };
                self.draw_path((0..=64).map(corner), style)
            }
        }
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        match self {
            Self::Svg(svg) => svg.fill_polygon(path, style),
            Self::Raster { raster, .. } => {
                raster.polygon(&pixels(path), rgb(style.color()), style.color().alpha);
                Ok(())
            }
        }
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Done {
        let (raster, em) = match self {
            Self::Svg(svg) => return svg.draw_text(text, style, at),
            Self::Raster { raster, .. } => (raster, style.size() / SIZE_OF_EM * DENSITY),
        };
        // As the SVG does it, from the anchor to the start of the baseline.
        let right = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * text_width(text, em),
            HPos::Right => -text_width(text, em),
        };
        let down = match style.anchor().v_pos {
            VPos::Top => 0.76 * em,
            VPos::Center => 0.5 * X_HEIGHT * em,
            VPos::Bottom => -0.5 * X_HEIGHT * em,
        };
        let (turn, moved) = match style.transform() {
            FontTransform::Rotate270 => (Turn::Up, DVec2::new(down, -right)),
            FontTransform::Rotate90 => (Turn::Down, DVec2::new(-down, right)),
            // No plot writes upside down.
            FontTransform::None | FontTransform::Rotate180 => (Turn::Right, DVec2::new(right, down)),
        };
        raster.text_turned(text, pixel(at) + moved, em, rgb(style.color()), style.color().alpha, turn);
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<io::Error>> {
        let em = style.size() / SIZE_OF_EM;
        Ok((text_width(text, em).ceil() as u32, em.ceil() as u32))
    }
}

/// Width in units of the drawing of a line of text in a font of `size`, as plotters means it.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    text_width(text, size / SIZE_OF_EM)
}
