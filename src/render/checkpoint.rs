//! The state of a rendering as a file, to the last bit.
//!
//! ```text
//! 8 bytes   "WFRENDER"
//! u32       version of this layout, 2
//! u32       length of the header
//! header    JSON: {"width", "height", "batch", "scene", "settings", "runs": [{"seed", "first", "count"}], "seconds"}
//! pixels    row by row from the top, 104 bytes each: u64 n, u64 nonfinite, u64 batches, f64 mean[3], f64 m2[3],
//!           u64 n and f64 sum[3] of the open batch
//! u64       checksum of all before: FNV-1a over words of 8 bytes, the last one filled up with 0
//! ```
//! Everything is little-endian. A file is read pixel by pixel, so one that declares more than it holds takes no more
//! memory than its own length.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::film::{Film, Open, Pixel};
use super::provenance::{Provenance, Run};
use crate::image::MAX_PIXELS;

const MAGIC: &[u8; 8] = b"WFRENDER";
const VERSION: u32 = 2;
const PIXEL_BYTES: usize = 104;
/// Scene and settings are a line each, and runs are few.
const LONGEST_HEADER: u32 = 1 << 20;

/// Why a file is no state of work that could go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Its content is wrong.
    #[error("{}: {reason}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

/// A film with the origin of its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The samples.
    pub film: Film,
    /// Which ones they are.
    pub provenance: Provenance,
}

#[derive(Serialize, Deserialize)]
struct Header {
    width: usize,
    height: usize,
    batch: u64,
    #[serde(flatten)]
    provenance: Provenance,
}

impl Checkpoint {
    /// Whether a file that begins with `bytes` claims to be a checkpoint.
    pub fn is_one(bytes: &[u8]) -> bool {
        bytes.starts_with(MAGIC)
    }

    /// The run that a rendering of `scene` with `settings` goes on with.
    ///
    /// Error, in words: another scene, other settings, another seed, or more than one run.
    pub fn resumable(&self, scene: &str, settings: &str, seed: u64) -> Result<Run, String> {
        let differ = |what: &str, theirs: &str, ours: &str| format!("it is of another {what}: {theirs}, not {ours}");
        let known = &self.provenance;
        match known.runs[..] {
            _ if known.scene != scene => Err(differ("scene", &known.scene, scene)),
            _ if known.settings != settings => Err(differ("setting", &known.settings, settings)),
            [run] if run.seed == seed && run.first == 0 => Ok(run),
            [run] if run.first == 0 => Err(differ("seed", &run.seed.to_string(), &seed.to_string())),
            _ => Err("its samples are no single run from the first on, so there is nothing to go on with".into()),
        }
    }

    /// The content of the file.
    pub fn encode(&self) -> Vec<u8> {
        let header = Header {
            width: self.film.width(),
            height: self.film.height(),
            batch: self.film.batch(),
            provenance: self.provenance.clone(),
        };
        // Plain data: serialising it has no way to fail.
        let header = serde_json::to_vec(&header).unwrap_or_default();
        let mut bytes = Vec::with_capacity(header.len() + PIXEL_BYTES * self.film.pixels().len() + 32);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((header.len() as u32).to_le_bytes());
        bytes.extend(header);
        for pixel in self.film.pixels() {
            bytes.extend(pixel_bytes(pixel));
        }
        let mut checksum = Checksum::default();
        checksum.add(&bytes);
        bytes.extend(checksum.value().to_le_bytes());
        bytes
    }

    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let file = File::open(path).map_err(|source| CheckpointError::Io { path: path.into(), source })?;
        Self::decode(BufReader::new(file)).map_err(|flaw| flaw.in_file(path))
    }

    fn decode(reader: impl Read) -> Result<Self, Flaw> {
        let mut reader = Checked::new(reader);
        if reader.take::<8>("mark")? != *MAGIC {
            return Err("is no checkpoint".to_string().into());
        }
        let version = u32::from_le_bytes(reader.take("version")?);
        if version != VERSION {
            return Err(format!("is a checkpoint of version {version}; read is {VERSION}").into());
        }
        let length = u32::from_le_bytes(reader.take("header")?);
        if length > LONGEST_HEADER {
            return Err(format!("its header has {length} bytes; allowed are {LONGEST_HEADER}").into());
        }
        let mut header = vec![0; length as usize];
        reader.fill(&mut header, "header")?;
        let Header { width, height, batch, provenance } =
            serde_json::from_slice(&header).map_err(|error| format!("its header is damaged: {error}"))?;
        let count = width.checked_mul(height).filter(|n| (1..=MAX_PIXELS).contains(n));
        let count =
            count.ok_or_else(|| format!("it declares {width} x {height} pixels; at most {MAX_PIXELS} are read"))?;
        if !batch.is_power_of_two() {
            return Err(format!("its batches have {batch} samples; allowed are powers of two").into());
        }
        check(&provenance)?;
        let samples = provenance.samples();
        let mut pixels = Vec::new();
        for at in 0..count {
            let pixel = pixel(&reader.take::<PIXEL_BYTES>(&format!("pixel {at} of {count}"))?);
            if !plausible(&pixel, samples) {
                return Err(format!("pixel {at} of {count} holds what no rendering leaves: {pixel:?}").into());
            }
            pixels.push(pixel);
        }
        reader.finish()?;
        let film =
            Film::from_pixels(width, height, pixels).ok_or_else(|| "its pixels do not fit its size".to_string())?;
        Ok(Self { film: film.with_batches(batch), provenance })
    }
}

fn check(provenance: &Provenance) -> Result<(), String> {
    let runs = &provenance.runs;
    let sorted = runs.windows(2).all(|pair| (pair[0].seed, pair[0].end()) <= (pair[1].seed, pair[1].first));
    let seconds = provenance.seconds >= 0.0 && provenance.seconds.is_finite();
    if sorted && seconds { Ok(()) } else { Err("its header is damaged: runs overlap, or time is negative".into()) }
}

fn plausible(pixel: &Pixel, samples: u64) -> bool {
    let Pixel { n, nonfinite, batches, mean, m2, open } = *pixel;
    // M2 may have overflowed.
    let moments = mean.is_finite() && open.sum.is_finite() && m2.to_array().iter().all(|m2| *m2 >= 0.0);
    let empty = batches > 0 || (mean, m2) == (DVec3::ZERO, DVec3::ZERO);
    let open_empty = open.n > 0 || open.sum == DVec3::ZERO;
    let counts = open.n <= n && batches <= n - open.n && (batches > 0) == (n > open.n);
    moments && empty && open_empty && counts && n.checked_add(nonfinite).is_some_and(|n| n <= samples)
}

fn pixel_bytes(pixel: &Pixel) -> [u8; PIXEL_BYTES] {
    let bits = |v: DVec3| v.to_array().map(f64::to_bits);
    let Pixel { n, nonfinite, batches, mean, m2, open } = *pixel;
    let words = [n, nonfinite, batches].into_iter().chain(bits(mean)).chain(bits(m2));
    let words = words.chain([open.n]).chain(bits(open.sum));
    let mut bytes = [0; PIXEL_BYTES];
    for (eight, word) in bytes.chunks_exact_mut(8).zip(words) {
        eight.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

fn pixel(bytes: &[u8; PIXEL_BYTES]) -> Pixel {
    let (words, _) = bytes.as_chunks::<8>();
    let word = |at: usize| u64::from_le_bytes(words[at]);
    let triple = |at: usize| DVec3::from_array([at, at + 1, at + 2].map(|at| f64::from_bits(word(at))));
    let open = Open { n: word(9), sum: triple(10) };
    Pixel { n: word(0), nonfinite: word(1), batches: word(2), mean: triple(3), m2: triple(6), open }
}

/// What is wrong, before the file has a name.
pub(crate) enum Flaw {
    /// It cannot be read.
    Io(io::Error),
    /// Its content, in words.
    Broken(String),
}

impl Flaw {
    pub(crate) fn in_file(self, path: &Path) -> CheckpointError {
        match self {
            Self::Io(source) => CheckpointError::Io { path: path.into(), source },
            Self::Broken(reason) => CheckpointError::Broken { path: path.into(), reason },
        }
    }
}

impl From<String> for Flaw {
    fn from(reason: String) -> Self {
        Self::Broken(reason)
    }
}

/// A reader that sums up what it has read.
pub(crate) struct Checked<R> {
    reader: R,
    checksum: Checksum,
}

impl<R: Read> Checked<R> {
    pub(crate) fn new(reader: R) -> Self {
        Self { reader, checksum: Checksum::default() }
    }

    /// Reads the checksum of all that was read; nothing may come after it.
    pub(crate) fn finish(mut self) -> Result<(), Flaw> {
        let expected = self.checksum.value();
        if u64::from_le_bytes(self.take("checksum")?) != expected {
            return Err("its checksum is wrong: the file is damaged".to_string().into());
        }
        if self.reader.read(&mut [0]).map_err(Flaw::Io)? > 0 {
            return Err("it goes on after its end".to_string().into());
        }
        Ok(())
    }

    /// Fills `bytes` with what comes next; `what` it is stands in the error of a file that ends before.
    pub(crate) fn fill(&mut self, bytes: &mut [u8], what: &str) -> Result<(), Flaw> {
        self.reader.read_exact(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => Flaw::Broken(format!("it ends before its {what}")),
            _ => Flaw::Io(error),
        })?;
        self.checksum.add(bytes);
        Ok(())
    }

    /// The next bytes.
    pub(crate) fn take<const N: usize>(&mut self, what: &str) -> Result<[u8; N], Flaw> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, what)?;
        Ok(bytes)
    }
}

/// FNV-1a over words of eight bytes: finds damage, not malice.
pub(crate) struct Checksum {
    hash: u64,
    word: [u8; 8],
    filled: usize,
}

impl Default for Checksum {
    fn default() -> Self {
        Self { hash: 0xcbf2_9ce4_8422_2325, word: [0; 8], filled: 0 }
    }
}

impl Checksum {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.word[self.filled] = byte;
            self.filled += 1;
            if self.filled == 8 {
                self.hash = self.mixed();
                (self.word, self.filled) = ([0; 8], 0);
            }
        }
    }

    fn mixed(&self) -> u64 {
        (self.hash ^ u64::from_le_bytes(self.word)).wrapping_mul(0x0000_0100_0000_01b3)
    }

    pub(crate) fn value(&self) -> u64 {
        if self.filled > 0 { self.mixed() } else { self.hash }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::color::Rgb;
    use crate::sampling::stream::{stream, uniform};

    /// Samples `range` of every pixel, some of them not finite.
    fn render(film: &mut Film, range: std::ops::Range<u64>) {
        for (at, pixel) in film.pixels_mut().iter_mut().enumerate() {
            for sample in range.clone() {
                let x = uniform(&mut stream(1, at as u64, sample));
                pixel.add(if x < 0.05 { Rgb::grey(f64::NAN) } else { Rgb::new(x, 1.0 / x, 0.1) }, 4);
            }
        }
    }

    fn checkpoint(count: u64) -> Checkpoint {
        let mut film = Film::new(5, 3).with_batches(4);
        render(&mut film, 0..count);
        let provenance = Provenance::new("Würfel", "mis", Run { seed: 1, first: 0, count }, 0.1);
        Checkpoint { film, provenance }
    }

    fn reason(bytes: &[u8]) -> String {
        match Checkpoint::decode(bytes) {
            Err(Flaw::Broken(reason)) => reason,
            Err(Flaw::Io(error)) => panic!("{error}"),
            Ok(_) => panic!("accepted"),
        }
    }

    fn decoded(bytes: &[u8]) -> Checkpoint {
        Checkpoint::decode(bytes).unwrap_or_else(|_| panic!("{}", reason(bytes)))
    }

    #[test]
    fn going_on_gives_the_bits_of_one_run() {
        let mut resumed = decoded(&checkpoint(20).encode());
        assert_eq!(resumed, checkpoint(20));
        let run = resumed.resumable("Würfel", "mis", 1).unwrap();
        render(&mut resumed.film, run.end()..50);
        assert_eq!(resumed.film, checkpoint(50).film);
        // Merging two halves agrees to rounding, not to the bit: hence the file keeps the state.
        let mut late = Film::new(5, 3).with_batches(4);
        render(&mut late, 20..50);
        let mut merged = checkpoint(20).film;
        merged.merge(&late).unwrap();
        assert_ne!(merged, resumed.film);
    }

    #[test]
    fn only_the_same_run_goes_on() {
        let saved = checkpoint(4);
        for (scene, settings, seed, words) in [
            ("Kugel", "mis", 1, "another scene: Würfel, not Kugel"),
            ("Würfel", "bsdf", 1, "another setting: mis, not bsdf"),
            ("Würfel", "mis", 2, "another seed: 1, not 2"),
        ] {
            let error = saved.resumable(scene, settings, seed).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
        let mut merged = saved.clone();
        let other = Provenance::new("Würfel", "mis", Run { seed: 2, first: 0, count: 4 }, 0.0);
        merged.provenance.merge(&other).unwrap();
        assert!(merged.resumable("Würfel", "mis", 1).unwrap_err().contains("no single run"));
    }

    #[test]
    fn damage_of_any_byte_is_found() {
        let bytes = checkpoint(4).encode();
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x10;
            assert!(!reason(&damaged).is_empty());
            assert!(reason(&bytes[..at]).starts_with("it ends before its "), "{at}");
        }
        let long = [bytes.as_slice(), &[0]].concat();
        assert_eq!(reason(&long), "it goes on after its end");
    }

    #[test]
    fn lies_cost_no_memory() {
        let lie = |header: &str| {
            let mut bytes = MAGIC.to_vec();
            bytes.extend(VERSION.to_le_bytes());
            bytes.extend((header.len() as u32).to_le_bytes());
            bytes.extend(header.bytes());
            reason(&bytes)
        };
        let header = |width: &str, runs: &str| {
            let sizes = format!(r#""width":{width},"height":16384,"batch":1"#);
            format!(r#"{{{sizes},"scene":"","settings":"","runs":[{runs}],"seconds":0}}"#)
        };
        assert!(lie(&header("16384", "")).starts_with("it ends before its pixel 0 of 268435456"));
        assert!(lie(&header("16385", "")).contains("at most 268435456"));
        assert!(lie(&header("18446744073709551615", "")).contains("at most 268435456"));
        let twice = r#"{"seed":1,"first":0,"count":9},{"seed":1,"first":8,"count":9}"#;
        assert!(lie(&header("1", twice)).contains("runs overlap"));
        assert!(lie("{").contains("header is damaged"));
        let odd = header("1", "").replace(r#""batch":1"#, r#""batch":3"#);
        assert!(lie(&odd).contains("batches have 3 samples"));
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(u32::MAX.to_le_bytes());
        assert!(reason(&bytes).contains("allowed are 1048576"));
    }

    #[test]
    fn pixels_that_no_rendering_leaves_are_refused() {
        let mut lying = checkpoint(4);
        lying.film.pixels_mut()[7].n = 5;
        assert!(reason(&lying.encode()).starts_with("pixel 7 of 15 holds what no rendering leaves"));
        let mut negative = checkpoint(4);
        negative.film.pixels_mut()[0].m2.x = -1.0;
        assert!(reason(&negative.encode()).starts_with("pixel 0 of 15"));
        let mut crowded = checkpoint(4);
        crowded.film.pixels_mut()[0].batches = 5;
        assert!(reason(&crowded.encode()).starts_with("pixel 0 of 15"));
    }
}
