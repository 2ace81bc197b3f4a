//! Pictures as files: named planes of f32 samples, and the formats that hold them.
//!
//! Read are PNG, JPEG, OpenEXR, Radiance HDR and PFM, told apart by their content, never by their name. Written are
//! OpenEXR (everything), PFM and HDR (colour) and PNG (a preview). Row 0 is the top one.
//!
//! A file may declare at most [`MAX_PIXELS`] pixels, [`MAX_SAMPLES`] samples over all planes and [`MAX_FILE_BYTES`]
//! bytes, and no more samples than its bytes could hold by the format's best compression: what is larger is refused
//! before anything is allocated for it.

mod error;
mod exr;
mod hdr;
mod jpeg;
mod pfm;
mod png;
pub mod srgb;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

pub use error::ImageError;
pub use png::preview;

/// The most pixels that a file may declare: 16384 x 16384.
pub const MAX_PIXELS: usize = 1 << 28;
/// The most samples that a file may declare, all planes together: 4 GiB of f32.
pub const MAX_SAMPLES: usize = 1 << 30;
/// The largest file that is read.
pub const MAX_FILE_BYTES: u64 = 1 << 32;

/// How a file stores its samples: what they mean, and how coarse they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Storage {
    /// f32 or u32.
    Float,
    /// f16, eleven significant bits.
    Half,
    /// Eight bits a channel under one exponent for all three.
    Rgbe,
    /// Integers of 16 bits with the sRGB curve.
    Srgb16,
    /// Integers of 8 bits with the sRGB curve.
    Srgb8,
}

impl Storage {
    /// The largest error of a stored `value` by rounding alone, where `brightest` is the pixel's largest channel.
    pub fn rounding(self, value: f64, brightest: f64) -> f64 {
        match self {
            Self::Float => value.abs() * f64::from(f32::EPSILON) / 2.0,
            Self::Half => value.abs() * 2_f64.powi(-11) + 2_f64.powi(-25),
            // The mantissa of the brightest channel has eight bits, of which the first is set.
            Self::Rgbe => brightest.abs() * 2_f64.powi(-8),
            Self::Srgb16 => srgb::steepness(value) * 0.5 / 65535.0,
            Self::Srgb8 => srgb::steepness(value) * 0.5 / 255.0,
        }
    }
}

/// A picture: planes of equal size with a name each, and words about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    planes: Vec<(String, Vec<f32>)>,
    /// The planes that stand for red, green and blue.
    colour: Option<[usize; 3]>,
    storage: Storage,
    metadata: BTreeMap<String, String>,
}

impl Image {
    /// An image without planes yet.
    pub fn new(width: usize, height: usize) -> Self {
        Self::stored(width, height, Storage::Float)
    }

    fn stored(width: usize, height: usize, storage: Storage) -> Self {
        Self { width, height, planes: Vec::new(), colour: None, storage, metadata: BTreeMap::new() }
    }

    /// An image of linear colours, row by row from the top: planes R, G and B.
    ///
    /// Error: `pixels` are not `width` x `height`.
    pub fn from_rgb(width: usize, height: usize, pixels: &[[f32; 3]]) -> Result<Self, ImageError> {
        let mut image = Self::new(width, height);
        for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
            image.push(name, pixels.iter().map(|pixel| pixel[channel]).collect())?;
        }
        Ok(image)
    }

    /// An image of 8-bit sRGB colours, row by row from the top.
    ///
    /// Error: `pixels` are not `width` x `height`.
    pub fn from_srgb8(width: usize, height: usize, pixels: &[[u8; 3]]) -> Result<Self, ImageError> {
        let mut image = Self::stored(width, height, Storage::Srgb8);
        for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
            image.push(name, pixels.iter().map(|pixel| f32::from(pixel[channel]) / 255.0).collect())?;
        }
        Ok(image)
    }

    /// Adds the plane `name` of samples, row by row from the top.
    ///
    /// Error: their number is not that of the pixels, or there is such a plane already.
    pub fn push(&mut self, name: &str, samples: Vec<f32>) -> Result<(), ImageError> {
        if samples.len() != self.width * self.height {
            let (width, height) = (self.width, self.height);
            return Err(ImageError::Plane { name: name.into(), samples: samples.len(), width, height });
        }
        if self.plane(name).is_some() {
            return Err(ImageError::PlaneTwice { name: name.into() });
        }
        self.planes.push((name.into(), samples));
        self.colour = colour_planes(&self.planes);
        Ok(())
    }

    /// Reads a file of any known format.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let unreadable = |source| ImageError::Io { path: path.into(), source };
        let mut file = File::open(path).map_err(unreadable)?;
        let mut bytes = Vec::new();
        file.by_ref().take(SNIFFED as u64).read_to_end(&mut bytes).map_err(unreadable)?;
        // Before the rest is read: whatever else lies there may be endless.
        if Codec::of(&bytes).is_none() {
            return Err(ImageError::Unknown { path: path.into() });
        }
        file.take(MAX_FILE_BYTES + 1 - bytes.len() as u64).read_to_end(&mut bytes).map_err(unreadable)?;
        Self::decode(&bytes, path)
    }

    /// Reads the content of a file. `name` stands in errors.
    pub fn decode(bytes: &[u8], name: &Path) -> Result<Self, ImageError> {
        let Some(codec) = Codec::of(bytes) else {
            return Err(ImageError::Unknown { path: name.into() });
        };
        let broken = |reason| ImageError::Broken { path: name.into(), format: codec.name(), reason };
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(broken(format!("the file is larger than {MAX_FILE_BYTES} bytes")));
        }
        codec.decode(bytes).map_err(broken)
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The names of the planes, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.planes.iter().map(|(name, _)| name.as_str())
    }

    /// The samples of the plane `name`, row by row from the top.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        self.planes.iter().find(|(known, _)| known == name).map(|(_, samples)| samples.as_slice())
    }

    /// The planes `prefix`R, `prefix`G and `prefix`B, where all three are there.
    pub fn triple(&self, prefix: &str) -> Option<[&[f32]; 3]> {
        let plane = |channel: &str| self.plane(&format!("{prefix}{channel}"));
        Some([plane("R")?, plane("G")?, plane("B")?])
    }

    /// The planes Variance.R, .G and .B: the variance of each pixel's mean.
    pub fn variance(&self) -> Option<[&[f32]; 3]> {
        self.triple("Variance.")
    }

    /// The opacity, plane A.
    pub fn alpha(&self) -> Option<&[f32]> {
        self.plane("A")
    }

    /// Whether some planes mean a colour: R, G and B; or Y alone (a grey); or those of the one layer that has them
    /// (`beauty.R`, …); or the only plane.
    pub fn has_colour(&self) -> bool {
        self.colour.is_some()
    }

    /// The planes of red, green and blue; a grey has one plane three times.
    pub fn colour(&self) -> Option<[&[f32]; 3]> {
        self.colour.map(|planes| planes.map(|plane| self.planes[plane].1.as_slice()))
    }

    /// The colour in column `x` and row `y` as it is stored; NaN where there is none, or no such pixel.
    pub fn rgb(&self, x: usize, y: usize) -> [f32; 3] {
        match self.colour {
            Some(planes) if x < self.width && y < self.height => {
                planes.map(|plane| self.planes[plane].1[y * self.width + x])
            }
            _ => [f32::NAN; 3],
        }
    }

    /// All colours as they are stored, row by row from the top.
    pub fn pixels_rgb(&self) -> Vec<[f32; 3]> {
        (0..self.width * self.height).map(|at| self.rgb(at % self.width, at / self.width)).collect()
    }

    /// Whether the colours carry the sRGB curve: values in [0, 1], from a PNG or a JPEG.
    pub fn is_srgb_encoded(&self) -> bool {
        matches!(self.storage, Storage::Srgb8 | Storage::Srgb16)
    }

    /// The linear colour in column `x` and row `y`.
    pub fn linear_rgb(&self, x: usize, y: usize) -> [f32; 3] {
        let rgb = self.rgb(x, y);
        if self.is_srgb_encoded() { rgb.map(|v| srgb::decode(f64::from(v)) as f32) } else { rgb }
    }

    /// All linear colours, row by row from the top.
    pub fn pixels_linear_rgb(&self) -> Vec<[f32; 3]> {
        (0..self.width * self.height).map(|at| self.linear_rgb(at % self.width, at / self.width)).collect()
    }

    /// How the file stored its coarsest plane.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// The words about the picture by their keys: attributes of an EXR, texts of a PNG, header lines of an HDR.
    pub fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    /// Sets one word about the picture.
    pub fn set_metadata(&mut self, key: &str, value: impl Into<String>) {
        self.metadata.insert(key.into(), value.into());
    }

    /// The content of a file in `format`.
    ///
    /// EXR holds every plane as f32, and the metadata. PFM holds the linear colours. HDR holds them to 8 bits, with 0
    /// in place of what is negative or NaN. PNG holds a preview: colours times 2^`exposure`, clamped to [0, 1], with
    /// the sRGB curve, in 8 bits; NaN is shown as magenta. Only PNG heeds `exposure`.
    ///
    /// Error: there is no colour, or the format does not hold images of this size.
    pub fn encode(&self, format: Format, exposure: f64) -> Result<Vec<u8>, ImageError> {
        let failed = |reason| ImageError::Encode { format: format.name(), reason };
        if !self.has_colour() {
            return Err(failed("the image has no colour".into()));
        }
        match format {
            Format::Exr => exr::encode(self),
            Format::Pfm => Ok(pfm::encode(self)),
            Format::Hdr => hdr::encode(self),
            Format::Png => png::encode(self, exposure),
        }
        .map_err(failed)
    }
}

/// The planes that mean red, green and blue, by their names.
fn colour_planes(planes: &[(String, Vec<f32>)]) -> Option<[usize; 3]> {
    let at = |name: &str| planes.iter().position(|(known, _)| known == name);
    let triple = |prefix: &str| {
        let channel = |name: &str| at(&format!("{prefix}{name}"));
        Some([channel("R")?, channel("G")?, channel("B")?])
    };
    let grey = || at("Y").or((planes.len() == 1).then_some(0)).map(|plane| [plane; 3]);
    let layer = || {
        // Variances are no colour, even where nothing else is there.
        let mut prefixes = planes.iter().filter_map(|(name, _)| name.strip_suffix('R')).filter(|p| *p != "Variance.");
        prefixes.find_map(|prefix| triple(prefix).filter(|_| prefix.ends_with('.')))
    };
    triple("").or_else(grey).or_else(layer)
}

/// Bytes from which a format is known.
const SNIFFED: usize = 16;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Codec {
    Png,
    Jpeg,
    Exr,
    Hdr,
    Pfm,
}

impl Codec {
    fn of(bytes: &[u8]) -> Option<Self> {
        let starts: [(&[u8], Self); 7] = [
            (b"\x89PNG\r\n\x1a\n", Self::Png),
            (b"\xff\xd8\xff", Self::Jpeg),
            (b"\x76\x2f\x31\x01", Self::Exr),
            (b"#?RADIANCE", Self::Hdr),
            (b"#?RGBE", Self::Hdr),
            (b"PF", Self::Pfm),
            (b"Pf", Self::Pfm),
        ];
        let (start, codec) = starts.into_iter().find(|(start, _)| bytes.starts_with(start))?;
        // Two letters alone could begin any text.
        let certain = codec != Self::Pfm || bytes.get(start.len()).is_some_and(u8::is_ascii_whitespace);
        certain.then_some(codec)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Exr => "OpenEXR",
            Self::Hdr => "Radiance HDR",
            Self::Pfm => "PFM",
        }
    }

    fn decode(self, bytes: &[u8]) -> Result<Image, String> {
        match self {
            Self::Png => png::decode(bytes),
            Self::Jpeg => jpeg::decode(bytes),
            Self::Exr => exr::decode(bytes),
            Self::Hdr => hdr::decode(bytes),
            Self::Pfm => pfm::decode(bytes),
        }
    }
}

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR, f32, all planes, lossless.
    Exr,
    /// Portable float map, f32, colours only.
    Pfm,
    /// Radiance HDR, 8 bits a channel and an exponent, colours only.
    Hdr,
    /// PNG, 8 bits with the sRGB curve: a preview.
    Png,
}

impl Format {
    /// The format that the extension of `path` names, whatever its case.
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("exr") => Ok(Self::Exr),
            Some("pfm") => Ok(Self::Pfm),
            Some("hdr" | "pic") => Ok(Self::Hdr),
            Some("png") => Ok(Self::Png),
            _ => Err(ImageError::Extension { path: path.into() }),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Exr => "OpenEXR",
            Self::Pfm => "PFM",
            Self::Hdr => "Radiance HDR",
            Self::Png => "PNG",
        }
    }
}

/// The number of pixels, if a file of `bytes` may hold `width` x `height` x `planes` samples.
///
/// `best` is the largest number of samples that one byte of the format can stand for.
fn plausible_size(width: usize, height: usize, planes: usize, bytes: usize, best: usize) -> Result<usize, String> {
    let declared = format!("it declares {width} x {height} pixels");
    let pixels = width.checked_mul(height).filter(|&n| n <= MAX_PIXELS);
    let Some(pixels) = pixels else { return Err(format!("{declared}; at most {MAX_PIXELS} are read")) };
    if pixels == 0 {
        return Err(format!("{declared}: none"));
    }
    let samples = pixels.checked_mul(planes.max(1)).filter(|&n| n <= MAX_SAMPLES);
    let Some(samples) = samples else {
        return Err(format!("{declared} of {planes} planes; at most {MAX_SAMPLES} samples are read"));
    };
    if samples / best > bytes {
        return Err(format!("{declared} of {planes} planes, more than its {bytes} bytes can hold"));
    }
    Ok(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn gradient() -> Image {
        let pixels: Vec<[f32; 3]> = (0..12_u8).map(|i| [f32::from(i), 0.25, 1.0 / f32::from(i + 1)]).collect();
        let mut image = Image::from_rgb(4, 3, &pixels).unwrap();
        image.push("Variance.R", vec![0.5; 12]).unwrap();
        image.set_metadata("scene", "a scene");
        image
    }

    #[test]
    fn planes_have_one_size_and_one_name() {
        let mut image = gradient();
        assert!(image.push("A", vec![0.0; 11]).is_err());
        assert!(image.push("R", vec![0.0; 12]).is_err());
        assert!(Image::from_rgb(2, 2, &[[0.0; 3]; 3]).is_err());
    }

    #[test]
    fn colours_are_found_by_the_names_of_planes() {
        let with = |names: &[&str]| {
            let mut image = Image::new(1, 1);
            for (i, name) in names.iter().enumerate() {
                image.push(name, vec![i as f32]).unwrap();
            }
            image.has_colour().then(|| image.rgb(0, 0))
        };
        assert_eq!(with(&["B", "G", "R", "Variance.R", "Variance.G", "Variance.B"]), Some([2.0, 1.0, 0.0]));
        assert_eq!(with(&["A", "Y"]), Some([1.0; 3]));
        assert_eq!(with(&["beauty.B", "beauty.G", "beauty.R", "z"]), Some([2.0, 1.0, 0.0]));
        assert_eq!(with(&["depth"]), Some([0.0; 3]));
        assert_eq!(with(&["n.X", "n.Y", "n.Z"]), None);
        assert_eq!(with(&["Variance.B", "Variance.G", "Variance.R"]), None);
    }

    #[test]
    fn a_pixel_that_is_not_there_is_nan() {
        assert!(gradient().rgb(4, 0)[0].is_nan() && gradient().rgb(0, 3)[0].is_nan());
    }

    #[test]
    fn formats_come_from_extensions_and_contents() {
        assert_eq!(Format::of(Path::new("a/b.EXR")).unwrap(), Format::Exr);
        let error = Format::of(Path::new("a.tiff")).unwrap_err().to_string();
        assert_eq!(error, "a.tiff: no image format has this extension; allowed are .exr, .pfm, .hdr and .png");
        let exr = gradient().encode(Format::Exr, 0.0).unwrap();
        assert_eq!(Image::decode(&exr, Path::new("liar.png")).unwrap().names().count(), 4);
        assert!(matches!(Image::decode(b"PFx", Path::new("x")), Err(ImageError::Unknown { .. })));
    }

    #[test]
    fn an_endless_file_of_no_known_format_is_not_read() {
        if Path::new("/dev/zero").exists() {
            assert!(matches!(Image::read(Path::new("/dev/zero")), Err(ImageError::Unknown { .. })));
        }
    }

    #[test]
    fn sizes_that_no_file_of_that_length_holds_are_refused() {
        assert!(plausible_size(100, 100, 3, 30_000, 1).is_ok());
        assert!(plausible_size(100, 100, 3, 29_000, 1).is_err());
        assert!(plausible_size(usize::MAX, 2, 3, 30_000, 1).is_err());
        assert!(plausible_size(1 << 14, 1 << 14, 5, usize::MAX, 1).is_err());
        assert!(plausible_size(0, 7, 1, 100, 1).is_err());
    }

    /// One small image in every format that can be made here; JPEG is read from real files elsewhere.
    fn encoded() -> Vec<Vec<u8>> {
        [Format::Exr, Format::Pfm, Format::Hdr, Format::Png].map(|f| gradient().encode(f, 0.0).unwrap()).into()
    }

    #[test]
    fn a_truncated_file_is_an_error_wherever_it_ends() {
        for whole in encoded() {
            // PNG's end mark and checksum may be missing: all pixels are there.
            for length in 0..whole.len() - 16 {
                let error = Image::decode(&whole[..length], Path::new("cut.img"));
                let text = error.expect_err("a prefix is no image").to_string();
                assert!(text.starts_with("cut.img: "), "{text}");
            }
        }
    }

    proptest! {
        #[test]
        fn damaged_files_never_panic(which in 0_usize..4, at in 0.0..1.0_f64, byte: u8, length in 0.5..1.0_f64) {
            let mut bytes = encoded().swap_remove(which);
            let place = (at * bytes.len() as f64) as usize;
            bytes[place] = byte;
            bytes.truncate((length * bytes.len() as f64) as usize);
            let _ = Image::decode(&bytes, Path::new("damaged"));
        }
    }
}
