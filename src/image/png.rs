//! PNG, read in 8 or 16 bits with any colour type, written as an 8-bit preview.

use std::io::Cursor;

use png::{BitDepth, ColorType, Transformations};

use super::{Image, Storage, plausible_size, srgb};

/// Deflate makes at most 1032 bytes of one, and a bit may be a sample.
const BEST: usize = 1032 * 8;

pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let said = |error: png::DecodingError| error.to_string();
    let limits = png::Limits { bytes: bytes.len().saturating_add(64 << 20) };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    // Palettes become colours, one to four bits become eight, a transparent colour becomes a plane A.
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(said)?;
    plausible_size(info.width as usize, info.height as usize, info.color_type.samples(), bytes.len(), BEST)?;
    let mut reader = decoder.read_info().map_err(said)?;
    let (colour, depth) = reader.output_color_type();
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let pixels = plausible_size(width, height, colour.samples(), bytes.len(), BEST)?;
    let mut content = vec![0; reader.output_buffer_size().ok_or("it is too large")?];
    reader.next_frame(&mut content).map_err(said)?;
    let storage = match depth {
        BitDepth::Sixteen => Storage::Srgb16,
        _ => Storage::Srgb8,
    };
    let names: &[&str] = match colour {
        ColorType::Grayscale => &["Y"],
        ColorType::GrayscaleAlpha => &["Y", "A"],
        ColorType::Rgb => &["R", "G", "B"],
        ColorType::Rgba => &["R", "G", "B", "A"],
        ColorType::Indexed => return Err("its palette could not be expanded".into()),
    };
    let mut image = Image::stored(width, height, storage);
    for (channel, name) in names.iter().enumerate() {
        let sample = |pixel: usize| {
            let at = pixel * names.len() + channel;
            match storage {
                Storage::Srgb16 => f32::from(u16::from_be_bytes([content[2 * at], content[2 * at + 1]])) / 65535.0,
                _ => f32::from(content[at]) / 255.0,
            }
        };
        image.push(name, (0..pixels).map(sample).collect()).map_err(|e| e.to_string())?;
    }
    for text in &reader.info().uncompressed_latin1_text {
        image.set_metadata(&text.keyword, text.text.clone());
    }
    for text in &reader.info().utf8_text {
        if let Ok(value) = text.get_text() {
            image.set_metadata(&text.keyword, value);
        }
    }
    Ok(image)
}

/// A linear colour in 8-bit sRGB, cut off at black and white; magenta where it is NaN.
pub fn preview(rgb: [f64; 3]) -> [u8; 3] {
    let byte = |v: f64| (srgb::encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8;
    if rgb.iter().any(|v| v.is_nan()) { [255, 0, 255] } else { rgb.map(byte) }
}

/// The preview, with the metadata as texts.
pub(super) fn encode(image: &Image, exposure: f64) -> Result<Vec<u8>, String> {
    let gain = exposure.exp2();
    let mut content = Vec::with_capacity(3 * image.width * image.height);
    for rgb in image.pixels_linear_rgb() {
        content.extend(preview(rgb.map(|v| f64::from(v) * gain)));
    }
    write(image.width, image.height, &content, image.metadata().iter())
}

/// A PNG of 8-bit sRGB triples.
fn write<'a>(
    width: usize,
    height: usize,
    content: &[u8],
    texts: impl Iterator<Item = (&'a String, &'a String)>,
) -> Result<Vec<u8>, String> {
    let said = |error: png::EncodingError| error.to_string();
    let side = |n: usize| u32::try_from(n).map_err(|_| "it is too large".to_string());
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side(width)?, side(height)?);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    // A PNG keyword has 1 to 79 characters; other formats allow more.
    for (key, value) in texts.filter(|(key, _)| (1..80).contains(&key.len())) {
        encoder.add_itxt_chunk(key.clone(), value.clone()).map_err(said)?;
    }
    let mut writer = encoder.write_header().map_err(said)?;
    writer.write_image_data(content).map_err(said)?;
    writer.finish().map_err(said)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preview_is_srgb_after_exposure() {
        let pixels = [[0.5, 0.25, 2.0], [f32::NAN, 0.0, -1.0]];
        let mut image = Image::from_rgb(2, 1, &pixels).unwrap();
        image.set_metadata("scene", "Würfel");
        let back = decode(&encode(&image, 1.0).unwrap()).unwrap();
        assert!(back.is_srgb_encoded());
        // Linear 0.5 is 188 of 255 in sRGB.
        assert_eq!(back.rgb(0, 0), [1.0, 188.0 / 255.0, 1.0]);
        assert_eq!(back.rgb(1, 0), [1.0, 0.0, 1.0]);
        assert_eq!(back.metadata()["scene"], "Würfel");
    }
}
