//! The face of the plots: a subset of DejaVu Sans that travels inside the program, so that pictures need no font of the
//! machine's.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, GlyphId, PxScale, ScaleFont, point};

/// The family's name in SVG.
pub(super) const FAMILY: &str = "DejaVu Sans";

/// Height of a lower-case x in ems.
pub(super) const X_HEIGHT: f64 = 0.547;

static BYTES: &[u8] = include_bytes!("font/DejaVuSans.ttf");

/// None never happens: a test reads the face.
fn face() -> Option<&'static FontRef<'static>> {
    static FACE: OnceLock<Option<FontRef<'static>>> = OnceLock::new();
    FACE.get_or_init(|| FontRef::try_from_slice(BYTES).ok()).as_ref()
}

/// The scale at which an em is this many pixels: ab_glyph counts from the highest ascender to the lowest descender.
fn scale(face: &FontRef<'_>, em: f64) -> PxScale {
    let units = f64::from(face.units_per_em().unwrap_or(2048.0));
    PxScale::from((em * f64::from(face.height_unscaled()) / units) as f32)
}

/// The glyphs of a line with their distances from its start, and its whole width, in pixels where an em has `em`.
fn set(face: &FontRef<'_>, text: &str, em: f64) -> (Vec<(GlyphId, f32)>, f32) {
    let scaled = face.as_scaled(scale(face, em));
    let mut pen = 0.0;
    let glyphs = text.chars().map(|c| {
        let glyph = face.glyph_id(c);
        let at = pen;
        pen += scaled.h_advance(glyph);
        (glyph, at)
    });
    (glyphs.collect(), pen)
}

/// Width of a line of text in pixels where an em has `em`.
pub fn text_width(text: &str, em: f64) -> f64 {
    face().map_or(0.0, |face| f64::from(set(face, text, em).1))
}

/// Calls `dot` with the pixels of a line of text whose baseline starts in the pixel (0, 0), moved right by the fraction
/// `shift`, and how much of each pixel is covered: from 0 to 1.
pub(super) fn rasterize(text: &str, em: f64, shift: f64, mut dot: impl FnMut(i32, i32, f64)) {
    let Some(face) = face() else { return };
    let scale = scale(face, em);
    for (glyph, at) in set(face, text, em).0 {
        let placed = glyph.with_scale_and_position(scale, point(at + shift as f32, 0.0));
        if let Some(outline) = face.outline_glyph(placed) {
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, covered| {
                dot(corner.x as i32 + x.cast_signed(), corner.y as i32 + y.cast_signed(), covered.into());
            });
        }
    }
}

/// The rule that gives an SVG this face, which it then carries.
pub(super) fn css() -> String {
    format!("@font-face{{font-family:\"{FAMILY}\";src:url(data:font/ttf;base64,{})}}", base64(BYTES))
}

/// RFC 4648, section 4.
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |at: usize| u32::from(chunk.get(at).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let known = digit <= chunk.len();
            text.push(if known { DIGITS[(word >> (18 - 6 * digit) & 63) as usize].into() } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_face_has_every_character_that_plots_write() {
        let face = face().expect("the face is sound");
        let written = "AZaz09 −±×·√∞≤≥≈∝σρθα°⁻⁰¹²³⁴⁵⁶⁷⁸⁹₀₁₂₃–—…’“”→←′∫∂∑•✓✗";
        assert!(written.chars().all(|c| face.glyph_id(c) != GlyphId(0)), "{written}");
        assert!(face.glyph_id('語') == GlyphId(0), "a subset");
        assert!(BYTES.len() <= 40_000);
    }

    #[test]
    fn widths_are_those_of_the_face() {
        // Advances in units of 2048 to the em: i 569, W 2025.
        let expected = (569.0 + 2025.0) / 2048.0 * 100.0;
        assert!((text_width("iW", 100.0) - expected).abs() < 1e-3, "single precision: {}", text_width("iW", 100.0));
        let (mut left, mut right, mut top) = (i32::MAX, i32::MIN, 0);
        rasterize("x", 100.0, 0.0, |x, y, covered| {
            if covered > 0.5 {
                (left, right, top) = (left.min(x), right.max(x), top.min(y));
            }
        });
        assert!(left >= 0 && f64::from(right) < text_width("x", 100.0));
        assert!((f64::from(-top) - 100.0 * X_HEIGHT).abs() <= 1.0, "a pixel: {top}");
    }

    #[test]
    fn base64_is_that_of_the_rfc() {
        let examples = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        assert!(examples.into_iter().all(|(plain, coded)| base64(plain.as_bytes()) == coded));
    }
}
