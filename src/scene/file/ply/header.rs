//! The header: what elements there are, how many of each, and of what numbers they are made.

use std::path::Path;

use crate::scene::file::error::{Place, SceneError, listed, quoted};

/// The longest header that is read [bytes].
const LONGEST_HEADER: usize = 1 << 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The largest value of an integer; colours of that type are shares of it.
    pub(super) fn full(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// The value in the first bytes of `bytes`.
    #[inline]
    pub(super) fn decode(self, bytes: &[u8], big: bool) -> Option<f64> {
        macro_rules! number {
            ($type:ty) => {{
                let raw = *bytes.first_chunk()?;
                f64::from(if big { <$type>::from_be_bytes(raw) } else { <$type>::from_le_bytes(raw) })
            }};
        }
        Some(match self {
            Self::I8 => number!(i8),
            Self::U8 => number!(u8),
            Self::I16 => number!(i16),
            Self::U16 => number!(u16),
            Self::I32 => number!(i32),
            Self::U32 => number!(u32),
            Self::F32 => number!(f32),
            Self::F64 => number!(f64),
        })
    }
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) value: Type,
    /// The type of the length, if it is a list.
    pub(super) length: Option<Type>,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    pub(super) line: u64,
}

impl Element {
    /// The fewest bytes that one takes.
    pub(super) fn least_size(&self, encoding: Encoding) -> u64 {
        let sizes = self.properties.iter().map(|p| match encoding {
            // A digit and a space or the end of the line.
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.value).size() as u64,
        });
        sizes.sum::<u64>()
    }

    pub(super) fn index(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.properties.iter().position(|p| p.name == *name && p.length.is_none()))
    }

    /// The properties with these names, all or none.
    pub(super) fn all<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let found = names.map(|name| self.index(&[name]));
        found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
    }
}

/// The encoding, the elements, and where the data starts.
pub(super) fn header(path: &Path, bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize), SceneError> {
    let bad = |line: u64, problem: String, allowed: &str| SceneError::Malformed {
        place: Place::line(path, line),
        problem,
        allowed: allowed.into(),
    };
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut at = 0;
    for line in 1.. {
        let rest = &bytes[at..bytes.len().min(LONGEST_HEADER)];
        let Some(length) = rest.iter().position(|&b| b == b'\n') else {
            return Err(SceneError::Truncated {
                place: Place::line(path, line),
                within: "its header".into(),
                allowed: format!("at most {LONGEST_HEADER} bytes that end in end_header"),
            });
        };
        at += length + 1;
        let text = String::from_utf8_lossy(&rest[..length]);
        let words: Vec<&str> = text.split_whitespace().collect();
        match words.as_slice() {
            ["ply"] if line == 1 => {}
            _ if line == 1 => return Err(bad(line, quoted(&text), "the word `ply`")),
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _version] => {
                encoding = Some(match *name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    other => {
                        let allowed = "ascii, binary_little_endian, binary_big_endian";
                        return Err(bad(line, format!("format {}", quoted(other)), allowed));
                    }
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad(line, quoted(&text), "element NAME COUNT"))?;
                elements.push(Element { name: (*name).to_string(), count, properties: Vec::new(), line });
            }
            ["property", kind @ .., name] => {
                const ALLOWED: &str = "property TYPE NAME or property list TYPE TYPE NAME, after an element; types are \
                                       char, uchar, short, ushort, int, uint, float, double, or int8 to float64";
                let property = match kind {
                    [value] => Type::parse(value).map(|value| (value, None)),
                    ["list", length, value] => {
                        let length = Type::parse(length).filter(|t| !matches!(t, Type::F32 | Type::F64));
                        length.zip(Type::parse(value)).map(|(length, value)| (value, Some(length)))
                    }
                    _ => None,
                };
                let (Some((value, length)), Some(element)) = (property, elements.last_mut()) else {
                    return Err(bad(line, quoted(&text), ALLOWED));
                };
                element.properties.push(Property { name: (*name).to_string(), value, length });
            }
            ["end_header"] => {
                let encoding = encoding.ok_or_else(|| bad(line, "no format".into(), "a line `format …`"))?;
                return Ok((encoding, elements, at));
            }
            _ => {
                let known = ["format", "comment", "obj_info", "element", "property", "end_header"];
                return Err(bad(line, quoted(&text), &listed(known)));
            }
        }
    }
    unreachable!("a file ends")
}
