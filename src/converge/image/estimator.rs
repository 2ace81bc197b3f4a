//! The estimators of an image by name: the path tracer's strategies, and its variants.

use crate::bsdf::subject::nearest_name;
use crate::render::path::{Heuristic, PathTracer, Roulette, Strategy};

/// The names, with what they are. Those that end in `=` take a value.
pub const NAMES: &[(&str, &str)] = &[
    ("mis", "light by chance and by connection, weighted"),
    ("direct", "a connection to a light at every surface"),
    ("bsdf", "light by chance alone"),
    ("random-connect", "a connection at one surface of the path, picked at random"),
    ("balance", "mis with the balance heuristic"),
    ("power", "mis with the power heuristic"),
    ("first-split=M", "mis, with M paths from the first surface, 1 to 1000000; also split=M"),
    ("roulette=Q", "mis, with paths that go on with probability Q in (0, 1]"),
];

/// The most paths from a first surface.
const MOST_PATHS: u32 = 1_000_000;

/// `base` with what `name` says of it; else why not, and what is allowed.
pub fn tracer(name: &str, base: PathTracer) -> Result<PathTracer, String> {
    let strategy = |strategy| PathTracer { strategy, ..base };
    let mis = strategy(Strategy::Mis);
    Ok(match name.split_once('=') {
        None => match name {
            "mis" => mis,
            "direct" => strategy(Strategy::Direct),
            "bsdf" => strategy(Strategy::Bsdf),
            "random-connect" => strategy(Strategy::RandomConnect),
            "balance" => PathTracer { heuristic: Heuristic::Balance, ..mis },
            "power" => PathTracer { heuristic: Heuristic::Power, ..mis },
            _ => return Err(unknown(name)),
        },
        Some(("first-split" | "split", m)) => {
            let paths = m.parse().ok().filter(|m| (1..=MOST_PATHS).contains(m));
            PathTracer {
                first_split: paths.ok_or_else(|| format!("allowed is a whole number from 1 to {MOST_PATHS}"))?,
                ..mis
            }
        }
        Some(("roulette", q)) => {
            let q = q.parse().ok().filter(|q| *q > 0.0 && *q <= 1.0);
            PathTracer { roulette: Roulette::Constant(q.ok_or("allowed is a probability in (0, 1]")?), ..mis }
        }
        Some(_) => return Err(unknown(name)),
    })
}

fn unknown(name: &str) -> String {
    format!("no such estimator of an image; {}", nearest_name(name, NAMES.iter().map(|(name, _)| *name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_what_they_say() {
        let of = |name| tracer(name, PathTracer::default());
        assert_eq!(of("mis"), Ok(PathTracer::default()));
        assert_eq!(of("power"), of("mis"));
        assert_eq!(of("balance").unwrap().heuristic, Heuristic::Balance);
        assert_eq!((of("split=4"), of("first-split=4").unwrap().first_split), (of("first-split=4"), 4));
        assert_eq!(of("roulette=0.5").unwrap().roulette, Roulette::Constant(0.5));
        for (name, _) in &NAMES[..6] {
            assert!(of(name).is_ok(), "{name}");
        }
    }

    #[test]
    fn others_are_refused_with_what_is_allowed() {
        let why = |name| tracer(name, PathTracer::default()).unwrap_err();
        assert!(why("drect").contains("did you mean direct?"));
        assert!(why("anything").contains("roulette=Q"), "{}", why("anything"));
        for name in ["split=0", "split=1e9", "split=", "roulette=0", "roulette=1.1", "roulette=NaN"] {
            assert!(why(name).contains("allowed is"), "{name}");
        }
    }
}
