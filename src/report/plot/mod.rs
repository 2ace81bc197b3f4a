//! Plots: as SVG that reads in light and in dark, and as PNG.
//!
//! Each function of this module makes a [`Figure`], which is drawn in the same way whatever it becomes. In the SVG, plotters
//! has one fixed colour for each role; a class is then added to each of these, and [`css`] says what the classes look like
//! in either colour scheme. A viewer without CSS still shows the light colours. Texts stay texts, in the face that the
//! file carries, or in the page's where the SVG stands in a page. The PNG shows the light colours on white.

mod albedo;
mod asymmetry;
mod canvas;
mod convergence;
mod first_split;
mod font;
mod frame;
mod histogram;
mod links;
mod lobes;
mod marks;
mod raster;
mod roulette;
mod shapes;
mod stores;
mod style;
mod variance;

use std::fmt;

use glam::DVec2;
use plotters::prelude::{IntoDrawingArea, SVGBackend};
use thiserror::Error;

use crate::image::ImageError;
use canvas::{Canvas, DENSITY};
use style::{Area, Drawn, SIZE, colour, px, themed};

pub use albedo::{ALBEDO_CUT, albedo};
pub use asymmetry::asymmetry;
pub use convergence::{Curve, convergence};
pub use first_split::first_split;
pub use font::text_width;
pub use histogram::histogram;
pub use links::links;
pub use lobes::{LOBE_ANGLES, lobes};
pub use raster::Raster;
pub use roulette::{RoulettePoint, roulette};
pub use stores::stores;
pub use style::css;
pub use variance::variance;

/// A plot, to be drawn.
pub struct Figure<'a> {
    name: &'static str,
    draw: Box<dyn Fn(&Area<'_>) -> Drawn + 'a>,
    picture: Option<Picture>,
}

/// A picture of pixels below what is drawn.
struct Picture {
    /// Its upper left and its lower right corner, in units of the drawing.
    corners: [(i32, i32); 2],
    raster: Raster,
}

/// A plot that cannot be drawn.
#[derive(Debug, Error)]
#[error("{name} cannot be drawn: {reason}")]
pub struct PlotError {
    /// What it shows.
    name: &'static str,
    /// Why not.
    reason: String,
}

impl<'a> Figure<'a> {
    fn new(name: &'static str, draw: impl Fn(&Area<'_>) -> Drawn + 'a) -> Self {
        Self { name, draw: Box::new(draw), picture: None }
    }

    fn with_picture(self, picture: Picture) -> Self {
        Self { picture: Some(picture), ..self }
    }

    fn draw_on(&self, canvas: Canvas<'_>) -> Result<(), PlotError> {
        let area = canvas.into_drawing_area();
        let drawn = (self.draw)(&area).and_then(|()| area.present().map_err(Into::into));
        drawn.map_err(|error| PlotError { name: self.name, reason: error.to_string() })
    }

    fn themed_svg(&self) -> Result<String, PlotError> {
        let mut svg = String::new();
        self.draw_on(Canvas::Svg(SVGBackend::with_string(&mut svg, units())))?;
        let mut svg = themed(&svg, self.name);
        if let Some(picture) = &self.picture {
            let head_end = svg.find('>').map_or(0, |at| at + 1);
            svg.insert_str(head_end, &picture.svg().map_err(|error| self.failed(&error))?);
        }
        Ok(svg)
    }

    fn failed(&self, error: &ImageError) -> PlotError {
        PlotError { name: self.name, reason: error.to_string() }
    }

    /// The SVG for a page that has the rules of [`css`]; a plot that cannot be drawn says so.
    pub fn inline(&self) -> String {
        self.themed_svg().unwrap_or_else(|_| format!("<p>{} could not be drawn.</p>", self.name))
    }

    /// The SVG as a file of its own: with its rules, its paper and its face.
    pub fn svg(&self) -> Result<String, PlotError> {
        let svg = self.themed_svg()?;
        let (head, body) = svg.split_at(svg.find('>').map_or(0, |at| at + 1));
        Ok(format!(
            "{head}\n<style>{}\n{}\nsvg text{{font-family:\"{}\",sans-serif}}</style>\n\
             <rect width=\"100%\" height=\"100%\" class=\"f-paper\" fill=\"#ffffff\"/>{body}",
            font::css(),
            css(),
            font::FAMILY,
        ))
    }

    /// The picture, twice as many pixels wide and high as the SVG is meant to be shown.
    pub fn raster(&self) -> Result<Raster, PlotError> {
        let size = units();
        let [width, height] = [size.0, size.1].map(|side| (f64::from(side) * DENSITY) as usize);
        let paper = colour(style::Role::Paper);
        let mut raster = Raster::new(width, height, [paper.0, paper.1, paper.2]);
        if let Some(picture) = &self.picture {
            picture.draw_on(&mut raster);
        }
        self.draw_on(Canvas::Raster { raster: &mut raster, size })?;
        Ok(raster)
    }

    /// The content of a PNG file that holds the picture.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        self.raster()?.png().map_err(|error| self.failed(&error))
    }
}

impl Picture {
    /// An element that holds its pixels, each of them sharp: those of a small picture are made larger, since not every
    /// viewer heeds the style.
    fn svg(&self) -> Result<String, ImageError> {
        const WIDE: usize = 640;
        let zoom = (WIDE / self.raster.width().max(1)).max(1);
        let mut shown = Raster::new(self.raster.width() * zoom, self.raster.height() * zoom, [0; 3]);
        shown.paste_zoomed(&self.raster, zoom);
        let [(left, top), (right, bottom)] = self.corners;
        let (width, height) = (right - left, bottom - top);
        Ok(format!(
            "\n<image x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>",
            font::base64(&shown.png()?)
        ))
    }

    /// The same on a raster: the pixels under the middle of each of its own.
    fn draw_on(&self, raster: &mut Raster) {
        let [from, to] = self.corners.map(|(x, y)| DENSITY * DVec2::new(x.into(), y.into()));
        let scale = DVec2::new(self.raster.width() as f64, self.raster.height() as f64) / (to - from);
        for y in from.y as usize..to.y as usize {
            for x in from.x as usize..to.x as usize {
                let at = (DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - from) * scale;
                if let Some(colour) = self.raster.pixel(at.x as usize, at.y as usize) {
                    raster.fill(x..x + 1, y..y + 1, colour);
                }
            }
        }
    }
}

impl fmt::Debug for Figure<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Figure {{ name: {:?} }}", self.name)
    }
}

/// The size of a drawing.
fn units() -> (u32, u32) {
    (px(SIZE.0) as u32, px(SIZE.1) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::probe::{AlbedoPoint, AsymmetryMap, Histogram};

    #[test]
    fn plots_are_themed_and_no_element_has_two_classes() {
        let point = |theta_deg, albedo| AlbedoPoint { theta_deg, albedo, resolved: true };
        let curve = [point(0.0, 0.5), point(80.0, 7.0), point(89.0, f64::NAN)];
        let map = AsymmetryMap { size: 2, cells: vec![0.0, 1e-7, 0.5, f64::NAN] };
        let h = Histogram {
            edges: vec![0.0, 0.5, 1.0],
            sampled: vec![0.5, 0.3, 0.1, 0.1],
            claimed: vec![0.4, 0.4, 0.1, 0.1],
            draws: 10,
            resolved: true,
        };
        let empty = Histogram { edges: vec![0.0], sampled: vec![], claimed: vec![], draws: 0, resolved: false };
        let black = vec![vec![(0.0, 0.0)]];
        let line = Curve {
            name: "cosine".into(),
            points: vec![(16.0, 0.1, 0.1), (64.0, 0.05, 0.1)],
            sigma: Some(0.4),
            theory: [-1.5, -0.5],
        };
        let furnace = crate::converge::roulette::Furnace::new(0.9, 0.93).unwrap();
        let measured = [RoulettePoint { furnace, variance: 60.0, std_err: Some(5.0) }];
        let figures = [
            albedo(&curve, &[]),
            asymmetry(&map),
            convergence(std::slice::from_ref(&line)),
            histogram(&h),
            histogram(&empty),
            lobes(&black),
            lobes(&[]),
            roulette(0.9, &measured),
        ];
        for figure in figures {
            let svg = figure.inline();
            assert!(svg.starts_with("<svg role=\"img\""), "{}", &svg[..80.min(svg.len())]);
            assert!(svg.contains("width=\"640\" height=\"420\" viewBox=\"0 0 2560 1680\""));
            for element in svg.split('<') {
                assert!(element.matches("class=").count() <= 1, "{element}");
                for colour in ["fill=\"#", "stroke=\"#"] {
                    assert!(!element.contains(colour) || element.contains("class="), "no role: {element}");
                }
            }
            let raster = figure.raster().unwrap();
            assert_eq!((raster.width(), raster.height()), (1280, 840));
            let paper = (0..1280 * 840).filter(|at| raster.pixel(at % 1280, at / 1280) == Some([255; 3])).count();
            assert!(paper < 1280 * 840, "{figure:?} is empty");
            assert_eq!(raster.pixel(0, 839), Some([255; 3]), "{figure:?} leaves a margin");
        }
    }

    #[test]
    fn a_file_of_its_own_fetches_nothing() {
        let svg = lobes(&[]).svg().unwrap();
        assert_eq!(svg.matches("url(").count(), 1);
        assert!(svg.contains("url(data:font/ttf;base64,AAEAAAA"), "the first bytes of every TrueType font");
        assert!(roxmltree::Document::parse(&svg).is_ok());
    }
}
