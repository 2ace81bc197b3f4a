//! Domains of parameters, and the one error of every constructor.

use std::fmt;

use crate::math::color::Rgb;

/// The values a parameter may take. `Display` is the text shown in errors and in the list of models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
    /// lo ≤ x ≤ hi.
    Closed(f64, f64),
    /// x ≥ lo, finite.
    AtLeast(f64),
    /// x > 0, finite.
    Positive,
    /// A colour whose channels each lie in lo ≤ x ≤ hi; hi may be infinite, the channels may not.
    Colour(f64, f64),
    /// One of these words.
    Word(&'static [&'static str]),
    /// Any text: the name of a file, of a material.
    Text,
    /// Another SUBJECT, in parentheses.
    Subject,
}

impl Domain {
    /// Whether the number `x` is allowed. NaN and infinities never are.
    pub fn contains(&self, x: f64) -> bool {
        x.is_finite()
            && match *self {
                Self::Closed(lo, hi) | Self::Colour(lo, hi) => lo <= x && x <= hi,
                Self::AtLeast(lo) => lo <= x,
                Self::Positive => x > 0.0,
                Self::Word(_) | Self::Text | Self::Subject => false,
            }
    }

    /// `value` if it is allowed, else the error that names model and parameter.
    pub fn check(self, model: &'static str, name: &'static str, value: f64) -> Result<f64, ParamError> {
        if self.contains(value) { Ok(value) } else { Err(ParamError::new(model, name, value, self)) }
    }

    /// `value` if each of its channels is allowed, else the error that names model and parameter.
    pub fn check_colour(self, model: &'static str, name: &'static str, value: Rgb) -> Result<Rgb, ParamError> {
        if value.to_array().iter().all(|&x| self.contains(x)) {
            Ok(value)
        } else {
            Err(ParamError::new(model, name, value, self))
        }
    }
}

impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Closed(lo, hi) => write!(f, "a number in [{lo}, {hi}]"),
            Self::AtLeast(lo) => write!(f, "a number ≥ {lo}"),
            Self::Positive => write!(f, "a number > 0"),
            Self::Colour(lo, hi) if hi.is_infinite() => write!(f, "a number or r/g/b, each ≥ {lo}"),
            Self::Colour(lo, hi) => write!(f, "a number or r/g/b, each in [{lo}, {hi}]"),
            Self::Word(words) => write!(f, "one of {}", words.join(", ")),
            Self::Text => write!(f, "text"),
            Self::Subject => write!(f, "a subject in parentheses"),
        }
    }
}

/// A parameter outside its domain: what a model's constructor returns instead of an invalid model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{model}: {name} = {value} is not allowed; allowed is {domain}")]
#[non_exhaustive]
pub struct ParamError {
    /// The model's name in the catalog.
    pub model: &'static str,
    /// The parameter's name.
    pub name: &'static str,
    /// The value given.
    pub value: String,
    /// What is allowed.
    pub domain: String,
}

impl ParamError {
    /// The error for `value`, with the allowed `domain` in words.
    pub fn new(model: &'static str, name: &'static str, value: impl fmt::Display, domain: impl fmt::Display) -> Self {
        Self { model, name, value: value.to_string(), domain: domain.to_string() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_and_infinity_are_in_no_domain() {
        for domain in
            [Domain::Closed(0.0, 1.0), Domain::AtLeast(0.0), Domain::Positive, Domain::Colour(0.0, f64::INFINITY)]
        {
            assert!(!domain.contains(f64::NAN) && !domain.contains(f64::INFINITY), "{domain}");
        }
    }

    #[test]
    fn the_error_says_what_where_and_what_is_allowed() {
        let error = Domain::Closed(0.0, 1.0).check("lambert", "rho", 1.5).unwrap_err();
        assert_eq!(error.to_string(), "lambert: rho = 1.5 is not allowed; allowed is a number in [0, 1]");
    }
}
