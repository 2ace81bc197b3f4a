//! Portable float map: `PF` (colour) or `Pf` (grey), width, height and scale in words, then f32 rows from the bottom.
//!
//! A negative scale means little-endian. Its size is not applied: programs do not agree on what it scales.

use super::{Image, plausible_size};

pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes.get(2..).unwrap_or_default();
    let planes = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let mut word = |what: &str| {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let length = rest[start..].iter().take(40).position(u8::is_ascii_whitespace);
        let length = length.ok_or_else(|| format!("the header has no {what}"))?;
        let text = String::from_utf8_lossy(&rest[start..start + length]).into_owned();
        // Exactly one white-space character ends the header.
        rest = &rest[start + length + 1..];
        Ok::<_, String>(text)
    };
    let number = |what: &str, text: String| text.parse::<usize>().map_err(|_| format!("{what} is {text:?}"));
    let width = number("the width", word("width")?)?;
    let height = number("the height", word("height")?)?;
    let scale = word("scale")?;
    let scale: f32 = scale.parse().ok().filter(|s: &f32| s.is_finite() && *s != 0.0).ok_or(format!("scale {scale}"))?;
    let pixels = plausible_size(width, height, planes, rest.len(), 1)?;
    let needed = pixels * planes * 4;
    if rest.len() < needed {
        return Err(format!("it ends after {} of {needed} bytes of pixels", rest.len()));
    }
    let sample = |at: usize| {
        let four = [rest[4 * at], rest[4 * at + 1], rest[4 * at + 2], rest[4 * at + 3]];
        if scale < 0.0 { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) }
    };
    let mut image = Image::new(width, height);
    let names: &[&str] = if planes == 3 { &["R", "G", "B"] } else { &["Y"] };
    for (channel, name) in names.iter().enumerate() {
        let place = |at: usize| ((height - 1 - at / width) * width + at % width) * planes + channel;
        image.push(name, (0..pixels).map(|at| sample(place(at))).collect()).map_err(|e| e.to_string())?;
    }
    Ok(image)
}

pub(super) fn encode(image: &Image) -> Vec<u8> {
    let mut bytes = format!("PF\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for y in (0..image.height).rev() {
        for x in 0..image.width {
            bytes.extend(image.linear_rgb(x, y).iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_from_the_bottom_in_either_byte_order() {
        let mut little = b"Pf\n1 2\n-1\n".to_vec();
        little.extend([2.0_f32, 1.0].iter().flat_map(|v| v.to_le_bytes()));
        let mut big = b"Pf 1 2 1.0\n".to_vec();
        big.extend([2.0_f32, 1.0].iter().flat_map(|v| v.to_be_bytes()));
        for bytes in [little, big] {
            let image = decode(&bytes).unwrap();
            assert_eq!((image.rgb(0, 0), image.rgb(0, 1)), ([1.0; 3], [2.0; 3]));
        }
    }

    #[test]
    fn every_bit_comes_back() {
        let pixels = [[1e-40, -0.0, f32::MAX], [f32::INFINITY, 0.1, -3.5]];
        let image = Image::from_rgb(2, 1, &pixels).unwrap();
        let back = decode(&encode(&image)).unwrap();
        assert_eq!(back.pixels_rgb().map_bits(), pixels.map_bits());
    }

    trait Bits {
        fn map_bits(&self) -> Vec<u32>;
    }

    impl<T: AsRef<[[f32; 3]]>> Bits for T {
        fn map_bits(&self) -> Vec<u32> {
            self.as_ref().iter().flatten().map(|v| v.to_bits()).collect()
        }
    }

    #[test]
    fn lies_are_refused() {
        for text in
            ["PF\n-1 2\n-1\n", "PF\n1000000000 1000000000\n-1\n", "PF\n9 9\n-1\nxx", "PF\n1 1\n0\n", "PF 1", "PF\n"]
        {
            assert!(decode(text.as_bytes()).is_err(), "{text}");
        }
    }
}
