//! JPEG, read only.

use std::io::Cursor;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::{Image, Storage, plausible_size};

/// An 8 x 8 block of one plane takes at least two codes of one bit: 256 samples in a byte. Progressive files split
/// them over scans, and runs of empty blocks take less: a generous factor on top.
const BEST: usize = 256 * 64;

pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let options = DecoderOptions::default().set_max_width(65535).set_max_height(65535).set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    let names: &[&str] = if grey { &["Y"] } else { &["R", "G", "B"] };
    let space = if grey { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.jpeg_set_out_colorspace(space));
    let info = decoder.info().ok_or("it has no header")?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    let pixels = plausible_size(width, height, names.len(), bytes.len(), BEST)?;
    let content = decoder.decode().map_err(|e| e.to_string())?;
    if content.len() != pixels * names.len() {
        return Err(format!("{} samples for {width} x {height} pixels", content.len()));
    }
    let mut image = Image::stored(width, height, Storage::Srgb8);
    for (channel, name) in names.iter().enumerate() {
        let samples = content.iter().skip(channel).step_by(names.len()).map(|&v| f32::from(v) / 255.0);
        image.push(name, samples.collect()).map_err(|e| e.to_string())?;
    }
    Ok(image)
}
