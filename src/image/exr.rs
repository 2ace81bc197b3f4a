//! OpenEXR: any flat file is read (half, float, uint; scan lines or tiles; every compression that the crate `exr` knows),
//! and one kind is written: f32 scan lines under ZIP, which every reader takes.
//!
//! The image is the data window. Planes of the first part keep their names; those of further parts are called
//! `part.channel`, and must have the same size.

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, SampleType, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, ReadChannels, ReadLayers, WritableImage,
    f16, read,
};

use super::{Image, Storage, plausible_size};

/// Deflate makes at most 1032 bytes of one, and DWA deflates one number for 64 samples.
const BEST: usize = 1032 * 8;

pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let said = |error: exr::error::Error| error.to_string();
    let meta = MetaData::read_from_buffered(bytes, false).map_err(said)?;
    let first = meta.headers.first().ok_or("it has no part")?;
    let size = first.layer_size;
    let mut planes = 0;
    let mut storage = Storage::Float;
    for header in &meta.headers {
        if header.deep {
            return Err("deep data is not read".into());
        }
        if header.layer_size != size {
            return Err("its parts differ in size".into());
        }
        for channel in &header.channels.list {
            let name = &channel.name;
            if channel.sampling.0 != 1 || channel.sampling.1 != 1 {
                return Err(format!("channel {name} is subsampled, which is not read"));
            }
            if channel.sample_type == SampleType::F16 {
                storage = Storage::Half;
            }
        }
        planes += header.channels.list.len();
        plausible_size(size.0, size.1, planes, bytes.len(), BEST)?;
    }
    let content = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(said)?;
    let mut image = Image::stored(size.0, size.1, storage);
    image.metadata = words(content.attributes.other.iter());
    for (part, layer) in content.layer_data.into_iter().enumerate() {
        let part_name = layer.attributes.layer_name.as_ref().map_or_else(|| part.to_string(), ToString::to_string);
        if part == 0 {
            let known = &layer.attributes;
            for (key, word) in
                [("software", &known.software_name), ("comments", &known.comments), ("owner", &known.owner)]
            {
                image.metadata.extend(word.as_ref().map(|word| (key.to_string(), utf8(word))));
            }
            image.metadata.extend(words(known.other.iter()));
        }
        for channel in layer.channel_data.list {
            let name = if part == 0 { channel.name.to_string() } else { format!("{part_name}.{}", channel.name) };
            let samples = match channel.sample_data {
                FlatSamples::F16(samples) => samples.into_iter().map(f16::to_f32).collect(),
                FlatSamples::F32(samples) => samples,
                FlatSamples::U32(samples) => samples.into_iter().map(|v| v as f32).collect(),
            };
            image.push(&name, samples).map_err(|e| e.to_string())?;
        }
    }
    Ok(image)
}

/// The attributes that are words or numbers.
fn words<'a>(attributes: impl Iterator<Item = (&'a Text, &'a AttributeValue)>) -> BTreeMap<String, String> {
    let word = |value: &AttributeValue| match value {
        AttributeValue::Text(text) => Some(utf8(text)),
        AttributeValue::F64(x) => Some(x.to_string()),
        AttributeValue::F32(x) => Some(x.to_string()),
        AttributeValue::I32(x) => Some(x.to_string()),
        _ => None,
    };
    attributes.filter_map(|(key, value)| Some((utf8(key), word(value)?))).collect()
}

/// The format leaves the encoding of texts open; ours is UTF-8, byte by byte.
fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

fn text(words: &str) -> Text {
    Text::from_bytes_unchecked(words.bytes().collect())
}

pub(super) fn encode(image: &Image) -> Result<Vec<u8>, String> {
    let channel = |(name, samples): &(String, Vec<f32>)| AnyChannel::new(text(name), FlatSamples::F32(samples.clone()));
    let channels = AnyChannels::sort(image.planes.iter().map(channel).collect());
    let mut attributes = LayerAttributes::default();
    for (key, value) in &image.metadata {
        let value = text(value);
        match key.as_str() {
            "software" => attributes.software_name = Some(value),
            "comments" => attributes.comments = Some(value),
            "owner" => attributes.owner = Some(value),
            // The crate refuses names with a meaning of their own, such as `version` and `view`.
            _ => drop(attributes.other.insert(text(key), AttributeValue::Text(value))),
        }
    }
    let encoding = Encoding {
        compression: exr::prelude::Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: exr::prelude::LineOrder::Increasing,
    };
    let layer = Layer::new((image.width, image.height), attributes, encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    exr::image::Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_comes_back() {
        let pixels: Vec<[f32; 3]> = (0..35 * 20).map(|i| [i as f32, 1e-30, f32::INFINITY]).collect();
        let mut image = Image::from_rgb(35, 20, &pixels).unwrap();
        image.push("Variance.R", vec![0.125; 35 * 20]).unwrap();
        image.push("Samples", (0..35 * 20).map(|i| i as f32).collect()).unwrap();
        image.set_metadata("scene", "Würfel, 1/3");
        image.set_metadata("samples", "64");
        image.set_metadata("software", "a program");
        let back = decode(&encode(&image).unwrap()).unwrap();
        assert_eq!(back.storage(), Storage::Float);
        assert_eq!(back.metadata(), image.metadata());
        for name in image.names() {
            assert_eq!(back.plane(name), image.plane(name), "{name}");
        }
        image.set_metadata("version", "a name that the format has taken");
        assert!(encode(&image).is_err());
    }
}
