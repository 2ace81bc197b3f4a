//! Indices of refraction of materials by the names that scene files use.
//!
//! Dielectrics have one index, at about 589 nm. Metals have η + i k per channel: the spectra of the luxpop collection
//! (and, where the name says so, of Palik's handbook), weighted by the CIE 1931 observer every 5 nm, linear in between,
//! in the light of equal energy, and turned into linear Rec.709, negative channels set to 0:
//!
//! c = M ∫ (x̄, ȳ, z̄) n(λ) dλ / ∫ ȳ dλ
//!
//! So does Mitsuba 3 with `material` in its rgb variants; the table was computed from the spectra and agrees with that to
//! four digits. It is a convention and no physics: equal energy is not the white of Rec.709, and a constant n has channels in the
//! ratio 1.205 : 0.948 : 0.909.
//! # References
//! - Jakob et al. 2022, Mitsuba 3 documentation, `dielectric` and `conductor` (the names); Palik 1998, Handbook of
//!   Optical Constants of Solids

use super::Fresnel;
use crate::math::color::Rgb;

/// The index of refraction of a transparent material, in absolute terms; None for an unknown name.
pub fn dielectric_ior(name: &str) -> Option<f64> {
    DIELECTRICS.iter().find(|(known, _)| *known == name).map(|(_, ior)| *ior)
}

/// The reflectance of a metal (or of an absorbing crystal); of `none`, that of the perfect mirror. None for an unknown
/// name.
pub fn metal(name: &str) -> Option<Fresnel> {
    if name == "none" {
        return Some(Fresnel::MIRROR);
    }
    let (_, eta, k) = METALS.iter().find(|(known, ..)| *known == name)?;
    Some(Fresnel::Conductor { eta: Rgb::from(*eta), k: Rgb::from(*k) })
}

/// The names that [`dielectric_ior`] knows.
pub fn dielectric_names() -> impl Iterator<Item = &'static str> + Clone {
    DIELECTRICS.iter().map(|(name, _)| *name)
}

/// The names that [`metal`] knows.
pub fn metal_names() -> impl Iterator<Item = &'static str> + Clone {
    METALS.iter().map(|(name, ..)| *name).chain(["none"])
}

static DIELECTRICS: &[(&str, f64)] = &[
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// Name, η, k.
#[rustfmt::skip] // One a line.
static METALS: &[(&str, [f64; 3], [f64; 3])] = &[
    ("a-C", [2.94405, 2.22714, 1.96816], [0.88747, 0.7993, 0.81529]),
    ("Ag", [0.15528, 0.11673, 0.13839], [4.82836, 3.12222, 2.1469]),
    ("Al", [1.6575, 0.88041, 0.52124], [9.22382, 6.26951, 4.83699]),
    ("AlAs", [3.60528, 3.23296, 2.21612], [0.00068, 0.0, 0.00751]),
    ("Au", [0.14304, 0.37531, 1.44204], [3.983, 2.38556, 1.60335]),
    ("Be", [4.18502, 3.18503, 2.78405], [3.83547, 3.01012, 2.86899]),
    ("Cr", [4.36967, 2.91651, 1.6549], [5.20655, 4.23131, 3.75469]),
    ("CsI", [2.1449, 1.70232, 1.66242], [0.0, 0.0, 0.0]),
    ("Cu", [0.201, 0.92375, 1.10221], [3.91327, 2.45305, 2.14209]),
    ("Cu2O", [3.55178, 2.94987, 2.75187], [0.11421, 0.1939, 0.60613]),
    ("CuO", [3.24754, 2.44781, 2.21021], [0.52109, 0.57003, 0.72218]),
    ("d-C", [2.71014, 2.31868, 2.22888], [0.0, 0.0, 0.0]),
    ("Hg", [2.39894, 1.44003, 0.90957], [6.32759, 4.37193, 3.42176]),
    ("HgTe", [4.77904, 3.2312, 2.6599], [1.63161, 1.58081, 1.72928]),
    ("Ir", [3.0863, 2.08219, 1.61791], [5.59216, 4.06709, 3.26731]),
    ("K", [0.06404, 0.04641, 0.03818], [2.1042, 1.34894, 0.91312]),
    ("Li", [0.26579, 0.19562, 0.22095], [3.54017, 2.31112, 1.6686]),
    ("MgO", [2.08959, 1.65072, 1.59488], [0.0, 0.0, 0.0]),
    ("Mo", [4.48398, 3.52513, 2.7763], [4.11144, 3.42083, 3.1506]),
    ("Na_palik", [0.06027, 0.05614, 0.06199], [3.17928, 2.11249, 1.57904]),
    ("Nb", [3.42008, 2.79009, 2.39562], [3.4414, 2.73767, 2.57974]),
    ("Ni_palik", [2.36731, 1.66337, 1.46707], [4.49882, 3.05015, 2.34543]),
    ("Rh", [2.5858, 1.86022, 1.55426], [6.78227, 4.70299, 3.97606]),
    ("Se", [4.05874, 2.84289, 2.82084], [0.75407, 0.63844, 0.52181]),
    ("SiC", [3.17234, 2.52597, 2.47936], [0.0, 0.0, 1e-05]),
    ("SnTe", [4.52425, 1.98165, 1.28159], [0.0, 0.0, 0.0]),
    ("Ta", [2.06272, 2.39294, 2.62792], [2.40836, 1.74149, 1.94702]),
    ("Te", [7.39024, 4.48211, 2.63709], [3.25602, 3.52707, 3.29203]),
    ("ThF4", [1.83072, 1.44223, 1.38764], [0.0, 0.0, 0.0]),
    ("TiC", [3.70053, 2.83742, 2.58228], [3.26564, 2.35159, 2.17279]),
    ("TiN", [1.64845, 1.15052, 1.37982], [3.36833, 1.9435, 1.10207]),
    ("TiO2", [3.45661, 2.80174, 2.90517], [0.00011, 0.0, 0.00065]),
    ("VC", [3.65757, 2.75274, 2.53267], [3.0683, 2.19869, 1.96319]),
    ("V_palik", [4.27759, 3.51295, 2.76107], [3.4913, 2.88946, 3.11152]),
    ("VN", [2.86561, 2.11919, 1.94009], [3.03225, 2.05612, 1.6163]),
    ("W", [4.37082, 3.30025, 2.9984], [3.50064, 2.60488, 2.27323]),
];

#[cfg(test)]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    #[test]
    fn names_are_known_and_others_are_not() {
        assert_eq!(dielectric_ior("water"), Some(1.333));
        assert!(dielectric_ior("unobtainium").is_none() && metal("").is_none());
        assert_eq!(metal("none"), Some(Fresnel::MIRROR));
        assert!(metal_names().all(|name| metal(name).is_some()));
        assert!(dielectric_names().all(|name| dielectric_ior(name).is_some()));
    }

    #[test]
    fn every_metal_is_a_valid_reflectance() {
        for name in metal_names() {
            assert!(metal(name).unwrap().validated("conductor").is_ok(), "{name}");
        }
    }

    /// (x, y) pairs of a text file, comments apart.
    fn pairs<const N: usize>(path: &Path, separator: char) -> Option<Vec<[f64; N]>> {
        let text = std::fs::read_to_string(path).ok()?;
        let row = |line: &str| -> Option<[f64; N]> {
            let cells: Option<Vec<f64>> =
                line.split(separator).filter(|cell| !cell.is_empty()).map(|cell| cell.trim().parse().ok()).collect();
            cells?.try_into().ok()
        };
        Some(text.lines().filter_map(row).collect())
    }

    fn linear<const N: usize>(table: &[[f64; N]], x: f64, column: usize) -> f64 {
        let i = table.partition_point(|row| row[0] <= x);
        if i == 0 || i == table.len() {
            return table.iter().find(|row| row[0] == x).map_or(0.0, |row| row[column]);
        }
        let (a, b) = (table[i - 1], table[i]);
        a[column] + (b[column] - a[column]) * (x - a[0]) / (b[0] - a[0])
    }

    /// The integral of the module's formula over one spectrum.
    fn rgb(observer: &[[f64; 4]], spectrum: &[[f64; 2]]) -> Rgb {
        const STEPS: u32 = 2000;
        let (mut xyz, mut white) = ([0.0; 3], 0.0);
        for i in 0..=STEPS {
            let lambda = 360.0 + 470.0 * f64::from(i) / f64::from(STEPS);
            let n = linear(spectrum, lambda, 1);
            for (sum, column) in xyz.iter_mut().zip(1..) {
                *sum += n * linear(observer, lambda, column);
            }
            white += linear(observer, lambda, 2);
        }
        let [x, y, z] = xyz.map(|sum| sum / white);
        // IEC 61966-2-1.
        let r = 3.240_479 * x - 1.537_150 * y - 0.498_535 * z;
        let g = -0.969_256 * x + 1.875_991 * y + 0.041_556 * z;
        Rgb::new(r, g, 0.055_648 * x - 0.204_043 * y + 1.057_311 * z)
    }

    #[test]
    fn metals_are_the_integrals_of_their_spectra() {
        let root = std::env::var_os("WHITEFURNACE_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
        let spectra = root.join("spectra");
        let Some(observer) = pairs::<4>(&spectra.join("cie1931_2deg_1nm.csv"), ',') else {
            eprintln!("skipped: {} is absent", spectra.display());
            return;
        };
        let observer: Vec<[f64; 4]> = observer.into_iter().filter(|row| row[0] % 5.0 == 0.0).collect();
        for (name, eta, k) in METALS {
            for (what, ours) in [("eta", eta), ("k", k)] {
                let spectrum = pairs::<2>(&spectra.join(format!("ior/{name}.{what}.spd")), ' ').unwrap();
                let expected = rgb(&observer, &spectrum).map(|x| x.max(0.0));
                // Five decimals, and the steps of the integral: some spectra begin or end in the middle of it.
                let gap = (expected - Rgb::from(*ours)).0.abs().max_element();
                assert!(gap <= 1e-5 + 4e-4 * expected.max_channel(), "{name} {what}: {expected}, off by {gap}");
            }
        }
    }

    #[test]
    fn metals_are_those_of_another_renderer() {
        // Mitsuba 3.9.1, scalar_rgb, `conductor` with `material`.
        for (name, eta, k) in [
            ("Ag", [0.155_276, 0.116_728, 0.138_388], [4.828_354, 3.122_222, 2.146_901]),
            ("Au", [0.143_036, 0.375_307, 1.442_045], [3.982_997, 2.385_556, 1.603_359]),
            ("Cr", [4.369_668, 2.916_505, 1.654_905], [5.206_547, 4.231_306, 3.754_699]),
        ] {
            let Some(Fresnel::Conductor { eta: ours, k: our_k }) = metal(name) else { panic!("{name}") };
            let gap = (ours - Rgb::from(eta)).0.abs().max_element().max((our_k - Rgb::from(k)).0.abs().max_element());
            assert!(gap <= 2e-4, "{name}: off by {gap}");
        }
    }
}
