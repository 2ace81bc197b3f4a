//! The text form of a model, `name:key=value,…`, and its typed arguments.
//!
//! A value may stand in parentheses: `mix:a=(lambert:rho=0.5),b=(ggx:alpha=0.2),t=0.3`.

use super::{Bsdf, Domain, ParamError, catalog};
use crate::math::color::Rgb;

/// Longest text of a subject, in bytes.
const MAX_LENGTH: usize = 16 * 1024;
/// Deepest nesting of subjects within subjects.
const MAX_DEPTH: usize = 8;

/// What a parameter is called, may be, and is when it is not given.
#[derive(Clone, Copy, Debug)]
pub struct ParamSpec {
    /// The key in `key=value`.
    pub name: &'static str,
    /// The allowed values.
    pub domain: Domain,
    /// What the parameter means, in a few words, with its unit.
    pub doc: &'static str,
    /// The value used when the key is absent.
    pub default: Option<&'static str>,
    /// Whether the key may be absent without having a default.
    pub optional: bool,
}

impl ParamSpec {
    /// A required parameter.
    pub const fn new(name: &'static str, domain: Domain, doc: &'static str) -> Self {
        Self { name, domain, doc, default: None, optional: false }
    }

    /// The same with a default value.
    #[must_use]
    pub const fn or(self, default: &'static str) -> Self {
        Self { default: Some(default), ..self }
    }

    /// The same, but allowed to be absent.
    #[must_use]
    pub const fn optional(self) -> Self {
        Self { optional: true, ..self }
    }
}

/// Why a subject could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SubjectError {
    /// The text is not of the form `name:key=value,…`.
    #[error("{text}: {reason}; a subject is name:key=value,…")]
    Syntax {
        /// The text.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// No model and no file has this name.
    #[error("{name}: no such model or file; {hint}")]
    UnknownModel {
        /// The name given.
        name: String,
        /// The nearest name, or all of them.
        hint: String,
    },
    /// The model has no such parameter.
    #[error("{model}: no parameter {name}; {hint}")]
    UnknownParam {
        /// The model.
        model: &'static str,
        /// The key given.
        name: String,
        /// The nearest key, or all of them.
        hint: String,
    },
    /// A required parameter is missing.
    #[error("{model}: {name} is missing; it takes {domain}")]
    MissingParam {
        /// The model.
        model: &'static str,
        /// The key that is missing.
        name: &'static str,
        /// What is allowed.
        domain: String,
    },
    /// A value outside its domain.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// A subject within a subject could not be made.
    #[error("{model}: in {name}: {source}")]
    Inner {
        /// The outer model.
        model: &'static str,
        /// The parameter that holds the inner subject.
        name: &'static str,
        /// What is wrong with it.
        source: Box<SubjectError>,
    },
    /// A file could not be read as what it is used for.
    #[error("{path}: {reason}")]
    File {
        /// The file.
        path: String,
        /// What is wrong, where in it, and what is allowed.
        reason: String,
    },
}

/// "did you mean X?" for the nearest of `names`, else "known are …".
pub fn nearest_name<'a>(given: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let nearest = names.clone().map(|name| (strsim::damerau_levenshtein(given, name), name)).min();
    match nearest {
        Some((distance, name)) if distance <= 1 + given.chars().count() / 3 => format!("did you mean {name}?"),
        _ => format!("known are {}", names.collect::<Vec<_>>().join(", ")),
    }
}

/// The arguments of one model, as texts that belong to its declared parameters.
#[derive(Debug)]
pub struct Args {
    model: &'static str,
    specs: &'static [ParamSpec],
    given: Vec<(&'static str, String)>,
    depth: usize,
}

impl Args {
    /// Splits `text` (what follows `name:`) into the arguments declared in `specs`.
    fn parse(model: &'static str, specs: &'static [ParamSpec], text: &str, depth: usize) -> Result<Self, SubjectError> {
        let syntax = |reason: &str| SubjectError::Syntax { text: format!("{model}:{text}"), reason: reason.into() };
        let mut given: Vec<(&'static str, String)> = Vec::new();
        for part in split_outside_parentheses(text).ok_or_else(|| syntax("unbalanced parentheses"))? {
            let (key, value) = part.split_once('=').ok_or_else(|| syntax(&format!("'{part}' has no '='")))?;
            let (key, value) = (key.trim(), value.trim());
            let spec = specs.iter().find(|s| s.name == key).ok_or_else(|| SubjectError::UnknownParam {
                model,
                name: key.into(),
                hint: nearest_name(key, specs.iter().map(|s| s.name)),
            })?;
            if given.iter().any(|(name, _)| *name == key) {
                return Err(syntax(&format!("{key} is given twice")));
            }
            let value = value.strip_prefix('(').and_then(|v| v.strip_suffix(')')).unwrap_or(value);
            given.push((spec.name, value.into()));
        }
        Ok(Self { model, specs, given, depth })
    }

    /// The arguments `pairs` of something else than a model that declares its parameters likewise, such as a scene.
    pub fn from_pairs<'a>(
        owner: &'static str,
        specs: &'static [ParamSpec],
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, SubjectError> {
        let mut args = Self { model: owner, specs, given: Vec::new(), depth: 0 };
        for (key, value) in pairs {
            let spec = specs.iter().find(|s| s.name == key).ok_or_else(|| {
                let name = key.chars().take(80).collect();
                let known = if specs.is_empty() {
                    "there are none".into()
                } else {
                    nearest_name(key, specs.iter().map(|s| s.name))
                };
                SubjectError::UnknownParam { model: owner, name, hint: known }
            })?;
            if args.is_given(spec.name) {
                return Err(ParamError::new(owner, spec.name, value, "one value; it is given twice").into());
            }
            args.given.push((spec.name, value.into()));
        }
        Ok(args)
    }

    /// The name of the model that the arguments are for.
    pub fn model(&self) -> &'static str {
        self.model
    }

    fn spec(&self, name: &str) -> &'static ParamSpec {
        let spec = self.specs.iter().find(|s| s.name == name);
        spec.unwrap_or_else(|| panic!("{} declares no parameter {name}", self.model))
    }

    /// The text given for `name`, else its default, else None.
    fn find(&self, name: &str) -> Option<&str> {
        let given = self.given.iter().find(|(key, _)| *key == name);
        given.map(|(_, value)| value.as_str()).or(self.spec(name).default)
    }

    fn bad(&self, name: &str, value: &str) -> SubjectError {
        let spec = self.spec(name);
        ParamError::new(self.model, spec.name, value, spec.domain).into()
    }

    /// The text of `name`, an error where it is missing.
    pub fn text(&self, name: &str) -> Result<&str, SubjectError> {
        self.find(name).ok_or_else(|| {
            let spec = self.spec(name);
            SubjectError::MissingParam { model: self.model, name: spec.name, domain: spec.domain.to_string() }
        })
    }

    /// Whether `name` was given.
    pub fn is_given(&self, name: &str) -> bool {
        self.given.iter().any(|(key, _)| *key == name)
    }

    /// The number `name` within its domain.
    pub fn number(&self, name: &str) -> Result<f64, SubjectError> {
        let text = self.text(name)?;
        let value = text.parse::<f64>().map_err(|_| self.bad(name, text))?;
        if self.spec(name).domain.contains(value) { Ok(value) } else { Err(self.bad(name, text)) }
    }

    /// The number `name` if it is given or has a default.
    pub fn optional_number(&self, name: &str) -> Result<Option<f64>, SubjectError> {
        if self.find(name).is_some() { self.number(name).map(Some) } else { Ok(None) }
    }

    /// The colour `name`, one number or `r/g/b`, within its domain.
    pub fn colour(&self, name: &str) -> Result<Rgb, SubjectError> {
        let text = self.text(name)?;
        let channels: Result<Vec<f64>, _> = text.split('/').map(str::parse::<f64>).collect();
        let colour = match channels.map_err(|_| self.bad(name, text))?[..] {
            [grey] => Rgb::grey(grey),
            [r, g, b] => Rgb::new(r, g, b),
            _ => return Err(self.bad(name, text)),
        };
        let domain = self.spec(name).domain;
        if colour.to_array().iter().all(|&x| domain.contains(x)) { Ok(colour) } else { Err(self.bad(name, text)) }
    }

    /// The colour `name` if it is given or has a default.
    pub fn optional_colour(&self, name: &str) -> Result<Option<Rgb>, SubjectError> {
        if self.find(name).is_some() { self.colour(name).map(Some) } else { Ok(None) }
    }

    /// The word `name`, one of those that its domain lists.
    pub fn word(&self, name: &str) -> Result<&'static str, SubjectError> {
        let text = self.text(name)?;
        let Domain::Word(words) = self.spec(name).domain else { return Err(self.bad(name, text)) };
        words.iter().find(|word| **word == text).copied().ok_or_else(|| self.bad(name, text))
    }

    /// The subject `name`, made into its model.
    pub fn subject(&self, name: &str) -> Result<Box<dyn Bsdf>, SubjectError> {
        let text = self.text(name)?;
        make(text, self.depth + 1).map_err(|source| SubjectError::Inner {
            model: self.model,
            name: self.spec(name).name,
            source: Box::new(source),
        })
    }
}

/// Splits at commas that stand outside parentheses; None where these do not balance.
fn split_outside_parentheses(text: &str) -> Option<Vec<&str>> {
    let (mut parts, mut depth, mut start) = (Vec::new(), 0_usize, 0);
    for (at, c) in text.char_indices() {
        match c {
            '(' => depth += 1,
            ')' => depth = depth.checked_sub(1)?,
            ',' if depth == 0 => {
                parts.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    (depth == 0).then(|| parts.into_iter().filter(|part| !part.trim().is_empty()).collect())
}

/// Makes the model that `text` names: `name:key=value,…`.
pub fn parse(text: &str) -> Result<Box<dyn Bsdf>, SubjectError> {
    make(text, 0)
}

fn make(text: &str, depth: usize) -> Result<Box<dyn Bsdf>, SubjectError> {
    let text = text.trim();
    let syntax = |reason: String| {
        let shown: String = text.chars().take(80).collect();
        Err(SubjectError::Syntax { text: shown, reason })
    };
    if text.is_empty() {
        return syntax("the subject is empty".into());
    }
    if text.len() > MAX_LENGTH {
        return syntax(format!("{} bytes are too long, {MAX_LENGTH} are allowed", text.len()));
    }
    if depth > MAX_DEPTH {
        return syntax(format!("subjects nest more than {MAX_DEPTH} deep"));
    }
    let (name, arguments) = text.split_once(':').unwrap_or((text, ""));
    let entry = catalog::find(name.trim()).ok_or_else(|| SubjectError::UnknownModel {
        name: name.trim().chars().take(80).collect(),
        hint: nearest_name(name.trim(), catalog::MODELS.iter().map(|e| e.name)),
    })?;
    (entry.build)(&Args::parse(entry.name, entry.params, arguments, depth)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn error(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn errors_are_one_line_with_what_where_and_what_is_allowed() {
        assert_eq!(error("lambrt:rho=1"), "lambrt: no such model or file; did you mean lambert?");
        assert_eq!(error("lambert:roh=1"), "lambert: no parameter roh; did you mean rho?");
        assert_eq!(
            error("lambert:rho=NaN"),
            "lambert: rho = NaN is not allowed; allowed is a number or r/g/b, each in [0, 1]"
        );
        assert_eq!(error("lambert:rho"), "lambert:rho: 'rho' has no '='; a subject is name:key=value,…");
        assert!(error("lambert:rho=1,rho=1").contains("given twice"));
        assert!(error("lambert:rho=(1").contains("unbalanced"));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC{0,60}") {
            let _ = parse(&text);
        }

        #[test]
        fn no_argument_text_panics(text in "[a-z0-9=,:/.()+-]{0,40}") {
            for entry in catalog::MODELS {
                let _ = parse(&format!("{}:{text}", entry.name));
            }
        }
    }
}
