//! Radiance HDR (RGBE): three mantissas of eight bits under one exponent.
//!
//! A channel is mantissa · 2^(exponent − 136), and is written rounded to nearest. Radiance itself truncates and adds
//! one half when reading; every renderer that we know reads as we do, so this is what a file is meant to say.
//! `EXPOSURE` and `PRIMARIES` are kept in the metadata and not applied, as in those renderers.
//! # References
//! - Ward 1991, Real pixels, Graphics Gems II
//! - Radiance's file formats, "Picture file format"

use super::{Image, Storage, plausible_size};

/// A run of 127 pixels' bytes takes two bytes, but each row takes four.
const BEST: usize = 64;
/// Widths that are written run by run; the format has no runs for others.
const RUN_WIDTHS: std::ops::Range<usize> = 8..0x8000;

pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let mut reader = Reader { rest: bytes };
    let mut header = Vec::new();
    loop {
        let line = reader.line().ok_or("the header has no end")?;
        if line.is_empty() {
            break;
        }
        header.push(line);
    }
    let axes = reader.line().ok_or("there is no line with the size")?;
    let place = Axes::parse(&axes).ok_or_else(|| format!("the size is {axes:?}; expected is -Y HEIGHT +X WIDTH"))?;
    let (width, height) = (place.width, place.height);
    let pixels = plausible_size(width, height, 3, reader.rest.len(), BEST)?;
    let mut planes = [vec![0.0; pixels], vec![0.0; pixels], vec![0.0; pixels]];
    let mut row = vec![[0_u8; 4]; width];
    for at in 0..height {
        reader.row(&mut row).ok_or_else(|| format!("row {} of {height} is cut short or damaged", at + 1))?;
        let y = if place.from_top { at } else { height - 1 - at };
        for (column, rgbe) in row.iter().enumerate() {
            let x = if place.from_left { column } else { width - 1 - column };
            for (plane, mantissa) in planes.iter_mut().zip(rgbe) {
                plane[y * width + x] = value(*mantissa, rgbe[3]);
            }
        }
    }
    let mut image = Image::stored(width, height, Storage::Rgbe);
    for line in header {
        match line.split_once('=') {
            Some(("FORMAT", format)) if format.trim() != "32-bit_rle_rgbe" => {
                return Err(format!("its format is {}; read is 32-bit_rle_rgbe", format.trim()));
            }
            Some((key, value)) => image.set_metadata(key.trim(), value.trim()),
            None => {}
        }
    }
    for (name, plane) in ["R", "G", "B"].into_iter().zip(planes) {
        image.push(name, plane).map_err(|e| e.to_string())?;
    }
    Ok(image)
}

fn value(mantissa: u8, exponent: u8) -> f32 {
    if exponent == 0 { 0.0 } else { (f64::from(mantissa) * (f64::from(exponent) - 136.0).exp2()) as f32 }
}

/// The size and the order of pixels. Rotated pictures (X before Y) are not read.
struct Axes {
    width: usize,
    height: usize,
    from_top: bool,
    from_left: bool,
}

impl Axes {
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [y, height, x, width] = words[..] else { return None };
        let from_top = ["-Y", "+Y"].contains(&y).then_some(y == "-Y")?;
        let from_left = ["-X", "+X"].contains(&x).then_some(x == "+X")?;
        Some(Self { width: width.parse().ok()?, height: height.parse().ok()?, from_top, from_left })
    }
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl Reader<'_> {
    /// The next line of the header, without its end.
    fn line(&mut self) -> Option<String> {
        const LONGEST: usize = 1 << 16;
        let end = self.rest.iter().take(LONGEST).position(|&b| b == b'\n')?;
        let line = String::from_utf8_lossy(&self.rest[..end]).trim_end_matches('\r').to_string();
        self.rest = &self.rest[end + 1..];
        Some(line)
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(*taken)
    }

    fn row(&mut self, row: &mut [[u8; 4]]) -> Option<()> {
        let [a, b, high, low] = *self.rest.first_chunk()?;
        let length = usize::from(u16::from_be_bytes([high, low]));
        if RUN_WIDTHS.contains(&row.len()) && (a, b) == (2, 2) && high < 0x80 {
            (length == row.len()).then_some(())?;
            self.take::<4>()?;
            (0..4).try_for_each(|channel| self.runs(row, channel))
        } else {
            self.plain(row)
        }
    }

    /// One channel of a row: runs and plain pieces.
    fn runs(&mut self, row: &mut [[u8; 4]], channel: usize) -> Option<()> {
        let mut at = 0;
        while at < row.len() {
            let [count] = self.take()?;
            let run = count > 128;
            let count = usize::from(if run { count - 128 } else { count });
            let piece = row.get_mut(at..at + count).filter(|piece| !piece.is_empty())?;
            let mut byte = 0;
            for (i, pixel) in piece.iter_mut().enumerate() {
                if !run || i == 0 {
                    [byte] = self.take()?;
                }
                pixel[channel] = byte;
            }
            at += count;
        }
        Some(())
    }

    /// Pixel by pixel, where (1, 1, 1, n) repeats the last one n times, and more such pixels shift n by 8 bits each.
    fn plain(&mut self, row: &mut [[u8; 4]]) -> Option<()> {
        let (mut at, mut shift) = (0, 0);
        while at < row.len() {
            let pixel = self.take::<4>()?;
            if pixel[..3] == [1, 1, 1] {
                let count = usize::from(pixel[3]).checked_shl(shift).filter(|&n| shift < 32 && n <= row.len() - at)?;
                let last = row[at.checked_sub(1)?];
                row[at..at + count].fill(last);
                at += count;
                shift += 8;
            } else {
                row[at] = pixel;
                at += 1;
                shift = 0;
            }
        }
        Some(())
    }
}

pub(super) fn encode(image: &Image) -> Result<Vec<u8>, String> {
    let (width, height) = (image.width, image.height);
    let mut bytes = b"#?RADIANCE\n".to_vec();
    for (key, value) in image.metadata() {
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        if key != "FORMAT" && !key.contains('=') {
            bytes.extend(format!("{}={}\n", one_line(key), one_line(value)).bytes());
        }
    }
    bytes.extend(format!("FORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").bytes());
    for y in 0..height {
        let row: Vec<[u8; 4]> = (0..width).map(|x| rgbe(image.linear_rgb(x, y))).collect();
        if !RUN_WIDTHS.contains(&width) {
            bytes.extend(row.iter().flatten());
            continue;
        }
        let length = u16::try_from(width).map_err(|_| "it is too wide")?;
        bytes.extend([2, 2]);
        bytes.extend(length.to_be_bytes());
        for channel in 0..4 {
            let values: Vec<u8> = row.iter().map(|pixel| pixel[channel]).collect();
            write_runs(&values, &mut bytes);
        }
    }
    Ok(bytes)
}

/// The nearest RGBE; 0 in place of what is negative or NaN, the largest in place of what is too large.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    let rgb = rgb.map(|v| f64::from(v).max(0.0));
    let brightest = rgb[0].max(rgb[1]).max(rgb[2]);
    // Below 2^-128 there is no exponent; 2^127 · 255/256 is the largest value.
    if brightest < 2_f64.powi(-128) {
        return [0; 4];
    }
    let mut exponent = brightest.log2().floor().min(126.0) as i32 + 1;
    // Rounding up must not need a ninth bit.
    if exponent < 127 && (brightest * f64::from(8 - exponent).exp2()).round() > 255.0 {
        exponent += 1;
    }
    let scale = f64::from(8 - exponent).exp2();
    let [r, g, b] = rgb.map(|v| (v * scale).round().min(255.0) as u8);
    [r, g, b, u8::try_from(exponent + 128).unwrap_or(u8::MAX)]
}

/// Runs of four and more as such, everything else plain.
fn write_runs(values: &[u8], bytes: &mut Vec<u8>) {
    let mut at = 0;
    let mut plain = 0;
    let flush = |from: usize, to: usize, bytes: &mut Vec<u8>| {
        for piece in values[from..to].chunks(128) {
            bytes.push(piece.len() as u8);
            bytes.extend(piece);
        }
    };
    while at < values.len() {
        let run = values[at..].iter().take(127).take_while(|&&v| v == values[at]).count();
        if run >= 4 {
            flush(plain, at, bytes);
            bytes.extend([128 + run as u8, values[at]]);
            at += run;
            plain = at;
        } else {
            at += run;
        }
    }
    flush(plain, values.len(), bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_to_half_a_step() {
        for width in [3_usize, 9, 300] {
            let value = |i: usize| (i as f32 * 0.37).sin().abs() * 10_f32.powf((i % 11) as f32 - 5.0);
            let pixels: Vec<[f32; 3]> =
                (0..width * 2).map(|i| [value(i), value(i / 7), if i % 90 > 5 { 0.0 } else { 1.0 }]).collect();
            let image = Image::from_rgb(width, 2, &pixels).unwrap();
            let back = decode(&encode(&image).unwrap()).unwrap();
            assert_eq!(back.storage(), Storage::Rgbe);
            for (a, b) in pixels.iter().zip(back.pixels_rgb()) {
                let brightest = f64::from(a[0].max(a[1]).max(a[2]));
                for (a, b) in a.iter().zip(b) {
                    let error = f64::from((a - b).abs());
                    assert!(error <= Storage::Rgbe.rounding(f64::from(*a), brightest), "{a} became {b}");
                }
            }
        }
    }

    #[test]
    fn extremes() {
        // Halves and ones are exact; 255.6/256 would round to a ninth bit.
        for v in [0.5, 1.0, 0.998_5, 2.0] {
            let [m, .., e] = rgbe([v; 3]);
            assert!((value(m, e) - v).abs() <= v / 256.0, "{v}");
        }
        assert_eq!(rgbe([f32::NAN, -1.0, 0.0]), [0; 4]);
        assert_eq!(rgbe([f32::INFINITY, 0.0, 0.0]), [255, 0, 0, 255]);
        assert_eq!(rgbe([1e-44; 3]), [0; 4]);
    }

    #[test]
    fn old_runs_and_mirrored_rows() {
        let mut bytes = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n+Y 1 -X 3\n".to_vec();
        bytes.extend([128, 0, 0, 129, 1, 1, 1, 1, 0, 128, 0, 129]);
        let image = decode(&bytes).unwrap();
        assert_eq!(image.pixels_rgb(), [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
        assert!(decode(&bytes[..bytes.len() - 1]).is_err());
    }
}
