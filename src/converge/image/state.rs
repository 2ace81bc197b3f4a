//! The state of a study of images as a file, to the last bit.
//!
//! ```text
//! 8 bytes   "WFSTUDY\n"
//! u32       version of this layout, 1
//! u32       length of the settings
//! text      the settings, UTF-8: everything that the bits depend on
//! u64 × 4   counts done, images of the next count, pixels of an image, samples left out of these images so far
//! f64       seconds that these images took
//! counts    11 words each: f64 variance, log_variance, largest_share, mean, std_err; u64 floor (0 none, 1 without z, 2);
//!           f64 floor, std_err, z, seconds; u64 nonfinite
//! images    one after the other, row by row, f64 r, g, b
//! u64       checksum of all before, as of a checkpoint
//! ```
//! Everything is little-endian. A file is read word by word and only up to the [`Extent`] of the study that goes on, so one
//! that lies takes no more memory than its own length.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::{Floor, Measured, Spread};
use crate::math::color::Rgb;
use crate::render::checkpoint::{Checked, CheckpointError, Checksum, Flaw};

const MAGIC: &[u8; 8] = b"WFSTUDY\n";
const VERSION: u32 = 1;
/// A line or two.
const LONGEST_SETTINGS: u32 = 1 << 20;

/// How large the state of a study may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Counts of all studies together.
    pub measured: usize,
    /// Images of a count.
    pub replicates: usize,
    /// Pixels of an image.
    pub pixels: usize,
}

/// What has been done so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// The counts that are done, study by study.
    pub measured: Vec<Measured>,
    /// The images of the next count that are done.
    pub images: Vec<Vec<Rgb>>,
    /// Processor seconds that these images took.
    pub seconds: f64,
    /// Samples of these images that were NaN or infinite.
    pub nonfinite: u64,
}

impl State {
    /// The content of the file of a study with these settings.
    pub fn encode(&self, settings: &str) -> Vec<u8> {
        let pixels = self.images.first().map_or(0, Vec::len);
        let mut bytes =
            Vec::with_capacity(settings.len() + 96 * self.measured.len() + 24 * pixels * self.images.len() + 72);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((settings.len() as u32).to_le_bytes());
        bytes.extend(settings.bytes());
        let sizes = [self.measured.len(), self.images.len(), pixels].map(|n| n as u64);
        let head = sizes.into_iter().chain([self.nonfinite, self.seconds.to_bits()]);
        let body = self.measured.iter().flat_map(words_of);
        let images = self.images.iter().flatten().flat_map(|c| c.to_array()).map(f64::to_bits);
        head.chain(body).chain(images).for_each(|word| bytes.extend(word.to_le_bytes()));
        let mut checksum = Checksum::default();
        checksum.add(&bytes);
        bytes.extend(checksum.value().to_le_bytes());
        bytes
    }

    /// The state in a file, for a study with these settings that is no larger than `extent`.
    pub fn read(path: &Path, settings: &str, extent: Extent) -> Result<Self, CheckpointError> {
        let file = File::open(path).map_err(|source| CheckpointError::Io { path: path.into(), source })?;
        Self::decode(BufReader::new(file), settings, extent).map_err(|flaw| flaw.in_file(path))
    }

    fn decode(reader: impl Read, settings: &str, extent: Extent) -> Result<Self, Flaw> {
        let mut reader = Checked::new(reader);
        if reader.take::<8>("mark")? != *MAGIC {
            return Err("is no state of a study".to_string().into());
        }
        let version = u32::from_le_bytes(reader.take("version")?);
        if version != VERSION {
            return Err(format!("is a state of version {version}; read is {VERSION}").into());
        }
        let length = u32::from_le_bytes(reader.take("settings")?);
        if length > LONGEST_SETTINGS {
            return Err(format!("its settings have {length} bytes; allowed are {LONGEST_SETTINGS}").into());
        }
        let mut theirs = vec![0; length as usize];
        reader.fill(&mut theirs, "settings")?;
        if theirs != settings.as_bytes() {
            let theirs = String::from_utf8_lossy(&theirs).chars().take(400).collect::<String>();
            return Err(format!("it is of another study: {theirs}; not {settings}").into());
        }
        let mut word = |what: &str| reader.take(what).map(u64::from_le_bytes);
        let (counts, images, pixels) = (word("counts")?, word("images")?, word("pixels")?);
        let (nonfinite, seconds) = (word("samples left out")?, f64::from_bits(word("seconds")?));
        let expected = if images > 0 { extent.pixels as u64 } else { 0 };
        let fits = counts <= extent.measured as u64
            && images < extent.replicates.max(1) as u64
            && (images == 0 || counts < extent.measured as u64);
        if !fits || pixels != expected {
            return Err(
                format!("it declares {counts} counts and {images} images of {pixels} pixels: no such study").into()
            );
        }
        let mut state = Self { seconds, nonfinite, ..Self::default() };
        for at in 0..counts {
            let mut words = [0; WORDS];
            for slot in &mut words {
                *slot = word(&format!("count {at} of {counts}"))?;
            }
            state.measured.push(measured(words)?);
        }
        for at in 0..images {
            let what = format!("image {at} of {images}");
            let mut image = Vec::new();
            for _ in 0..pixels {
                let mut channel = || word(&what).map(f64::from_bits);
                image.push(Rgb::new(channel()?, channel()?, channel()?));
            }
            state.images.push(image);
        }
        reader.finish()?;
        Ok(state)
    }
}

const WORDS: usize = 11;

fn words_of(measured: &Measured) -> [u64; WORDS] {
    let Measured { spread, seconds, nonfinite } = measured;
    let kind = spread.floor.map_or(0, |floor| 1 + u64::from(floor.z.is_some()));
    let floor = spread.floor.map_or([0.0; 3], |floor| [floor.value, floor.std_err, floor.z.unwrap_or(0.0)]);
    let [variance, log, share, mean, err] =
        [spread.variance, spread.log_variance, spread.largest_share, spread.mean, spread.std_err].map(f64::to_bits);
    let [value, std_err, z] = floor.map(f64::to_bits);
    [variance, log, share, mean, err, kind, value, std_err, z, seconds.to_bits(), *nonfinite]
}

fn measured(words: [u64; WORDS]) -> Result<Measured, Flaw> {
    let real = |at: usize| f64::from_bits(words[at]);
    let floor = match words[5] {
        0 => None,
        1 => Some(Floor { value: real(6), std_err: real(7), z: None }),
        2 => Some(Floor { value: real(6), std_err: real(7), z: Some(real(8)) }),
        kind => return Err(format!("it has a floor of kind {kind}").into()),
    };
    let spread = Spread {
        variance: real(0),
        log_variance: real(1),
        largest_share: real(2),
        mean: real(3),
        std_err: real(4),
        floor,
    };
    Ok(Measured { spread, seconds: real(9), nonfinite: words[10] })
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTENT: Extent = Extent { measured: 4, replicates: 6, pixels: 7 };

    fn state() -> State {
        let spread = Spread {
            variance: 0.1,
            log_variance: f64::MIN_POSITIVE,
            largest_share: 0.3,
            mean: -1.0,
            std_err: 1e-9,
            floor: None,
        };
        let floor = |z| Some(Floor { value: -1e-3, std_err: 2e-4, z });
        let spreads = [spread, Spread { floor: floor(None), ..spread }, Spread { floor: floor(Some(-0.5)), ..spread }];
        let image = |r: u8| (0..7_u8).map(|at| Rgb::new(f64::from(at) / 3.0, f64::from(r), -0.1)).collect();
        State {
            measured: spreads.into_iter().map(|spread| Measured { spread, seconds: 2.5, nonfinite: 3 }).collect(),
            images: (0..5).map(image).collect(),
            seconds: 0.7,
            nonfinite: 9,
        }
    }

    fn reason(bytes: &[u8], settings: &str, extent: Extent) -> String {
        match State::decode(bytes, settings, extent) {
            Err(Flaw::Broken(reason)) => reason,
            Err(Flaw::Io(error)) => panic!("{error}"),
            Ok(_) => panic!("accepted"),
        }
    }

    #[test]
    fn a_state_comes_back_to_the_bit() {
        for state in [state(), State { images: Vec::new(), ..state() }, State::default()] {
            let back = State::decode(state.encode("box, mis").as_slice(), "box, mis", EXTENT);
            assert!(back.is_ok_and(|back| back == state));
        }
    }

    #[test]
    fn damage_of_any_byte_and_any_end_is_found() {
        let bytes = state().encode("box, mis");
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(!reason(&damaged, "box, mis", EXTENT).is_empty());
            assert!(reason(&bytes[..at], "box, mis", EXTENT).starts_with("it ends before its "), "{at}");
        }
        assert_eq!(reason(&[bytes.as_slice(), &[0]].concat(), "box, mis", EXTENT), "it goes on after its end");
    }

    #[test]
    fn other_studies_and_lies_are_refused() {
        let bytes = state().encode("box, mis");
        assert_eq!(reason(&bytes, "box, bsdf", EXTENT), "it is of another study: box, mis; not box, bsdf");
        for extent in [
            Extent { measured: 2, ..EXTENT },
            Extent { measured: 3, ..EXTENT },
            Extent { replicates: 5, ..EXTENT },
            Extent { pixels: 8, ..EXTENT },
        ] {
            assert!(reason(&bytes, "box, mis", extent).contains("no such study"), "{extent:?}");
        }
        // Sizes without the content take no memory.
        let mut lie = bytes[..16 + 8].to_vec();
        for word in [1_u64 << 60, 1 << 60, 1 << 60, 0, 0] {
            lie.extend(word.to_le_bytes());
        }
        let vast = Extent { measured: usize::MAX, replicates: usize::MAX, pixels: 1 << 60 };
        assert!(reason(&lie, "box, mis", vast).starts_with("it ends before its count 0"));
        assert!(reason(b"WFRENDER", "box, mis", EXTENT).contains("is no state"));
    }
}
