//! The table of twins.

use super::interface_twins;
use super::{
    Asymmetric, BelowTheHorizon, BiasedLobe, Chimera, ClampedCosine, Correlated, CosineInEval, DensityOff,
    DividedByCosine, Dropped, ExtraPi, FalseClaim, FlippedPdf, FresnelInPdf, Gain, GainAtGrazing, HalfTurn, Hole, Leak,
    MirroredHalfVector, MissingCosine, MissingPi, MissingSquareRoot, NanAtCosineOne, NanAtTheNormal, NanAtZero,
    Negative, OnlyOnAverage, RareHugeWeight, Redrawn, ReusedUniform, Rotated, ScaledPdf, StaleWeight,
    UnflippedHalfVector, UniformPdf, Unmatched, VCavityPdf, WeightOff, WrongAlbedo, WrongJacobian, ggx_masking,
    no_masking, rational_beckmann, remapped_schlick, rougher_ggx,
};
use crate::bsdf::microfacet::{BeckmannNormals, GgxNormals, Microfacet};
use crate::bsdf::{Bsdf, subject};

/// A correct model and a copy of it with one mistake.
#[derive(Clone, Copy, Debug)]
pub struct Twin {
    /// What the mistake is called.
    pub name: &'static str,
    /// What it is, in one sentence.
    pub why: &'static str,
    /// The checks that must reject the copy.
    pub caught_by: &'static [&'static str],
    /// The correct model: it must pass every check.
    pub original: fn() -> Box<dyn Bsdf>,
    /// The copy with the mistake.
    pub broken: fn() -> Box<dyn Bsdf>,
}

/// The model that a subject of the table below names.
pub(super) fn model(text: &str) -> Box<dyn Bsdf> {
    subject::parse(text).unwrap_or_else(|error| panic!("a twin's subject is wrong: {error}"))
}

/// An entry for a wrapper around the model named by `$subject`.
macro_rules! wrapped {
    ($name:literal, $why:literal, $caught:expr, $subject:expr, $wrapper:ident $(, $number:expr)*) => {
        Twin {
            name: $name,
            why: $why,
            caught_by: &$caught,
            original: || model($subject),
            broken: || Box::new($wrapper(model($subject) $(, $number)*)),
        }
    };
}

pub(super) use wrapped;

/// An entry for f and density of `$subject` (density of `$pdf`, where given) and the draws of `$draws`.
macro_rules! chimera {
    ($name:literal, $why:literal, $caught:expr, $subject:expr, $pdf:expr, $draws:expr) => {
        Twin {
            name: $name,
            why: $why,
            caught_by: &$caught,
            original: || model($subject),
            broken: || Box::new(Chimera { f: model($subject), pdf: model($pdf), draws: model($draws) }),
        }
    };
}

/// An entry for microfacets of width 0.3 with the normals `$normals`, scaled by `$scale`, and the masking `$lambda`.
macro_rules! unmatched {
    ($name:literal, $why:literal, $caught:expr, $subject:expr, $normals:ident, $scale:expr, $lambda:expr) => {
        Twin {
            name: $name,
            why: $why,
            caught_by: &$caught,
            original: || model($subject),
            broken: || {
                let normals =
                    $normals::new(0.3, 0.3).unwrap_or_else(|error| panic!("a twin's width is wrong: {error}"));
                Box::new(Microfacet::from_normals(Unmatched { normals, scale: $scale, lambda: $lambda }))
            },
        }
    };
}

const LAMBERT: &str = "lambert:rho=0.8";
const WHITE: &str = "lambert:rho=1";
const LOBE: &str = "ggx:alpha=0.3";
/// Wide, so that many draws are lost below the horizon.
const WIDE: &str = "ggx:alpha=0.4";
const TWO_LOBES: &str = "ashikhmin-shirley:nu=100,nv=100,rd=0.5,rs=0.3";
const BECKMANN: &str = "beckmann:alpha=0.3";
const MIXTURE: &str = "mix:a=(lambert:rho=0.8),b=(ggx:alpha=0.1),t=0.5";
const PHONG: &str = "phong:n=10,kd=0,ks=0.8,norm=n+2";

/// Every twin.
pub fn twins() -> Vec<&'static Twin> {
    TWINS.iter().chain(interface_twins::TWINS).collect()
}

static TWINS: &[Twin] = &[
    // f itself.
    wrapped!(
        "missing_pi",
        "f is rho instead of rho/π",
        ["energy_eye", "energy_light", "white_furnace"],
        LAMBERT,
        MissingPi
    ),
    wrapped!("extra_pi", "f is divided by π twice, and the furnace goes dark", ["white_furnace"], WHITE, ExtraPi),
    wrapped!(
        "cosine_in_eval",
        "f contains the cosine that the renderer applies",
        ["reciprocity"],
        LAMBERT,
        CosineInEval
    ),
    wrapped!(
        "divided_by_cosine",
        "f is divided by n·l: right for every view, unbounded for a grazing light",
        ["reciprocity", "energy_light"],
        LAMBERT,
        DividedByCosine
    ),
    wrapped!("gain", "f is 0.01 % too large", ["energy_eye", "energy_light", "white_furnace"], WHITE, Gain, 1.0001),
    wrapped!(
        "gain_at_grazing",
        "f is 0.01 % too large within 0.2 degrees of the horizon",
        ["energy_eye", "energy_light"],
        WHITE,
        GainAtGrazing,
        1.0001,
        0.2_f64.to_radians().sin()
    ),
    wrapped!(
        "asymmetric",
        "swapping eye and light changes f by a millionth",
        ["reciprocity"],
        LAMBERT,
        Asymmetric,
        1e-6
    ),
    wrapped!("nan_at_the_normal", "a vector of length 0 is normalised at wo = n", ["finite"], LOBE, NanAtTheNormal),
    wrapped!(
        "nan_at_cosine_one",
        "√(1 − c²) of a cosine that rounds to 1 or more",
        ["finite"],
        LAMBERT,
        NanAtCosineOne
    ),
    wrapped!("negative", "a correction term undershoots 0 where both directions graze", ["finite"], LAMBERT, Negative),
    wrapped!(
        "wrong_albedo",
        "the closed form of the albedo is 0.01 % off",
        ["white_furnace"],
        LAMBERT,
        WrongAlbedo,
        1.0001
    ),
    wrapped!("false_claim", "a model that loses energy claims to lose none", ["white_furnace"], LOBE, FalseClaim),
    // Density and weight.
    wrapped!(
        "wrong_jacobian",
        "the pdf forgets the 1 / (4 wo·m) of the half-vector map",
        ["pdf_mass", "chi2"],
        LOBE,
        WrongJacobian
    ),
    wrapped!("pdf_too_large", "the pdf is 1 % too large", ["pdf_mass"], LOBE, ScaledPdf, 1.01),
    wrapped!("pdf_too_small", "the pdf is 1 % too small", ["pdf_mass"], LOBE, ScaledPdf, 0.99),
    wrapped!(
        "n_plus_2_for_n_plus_1",
        "the pdf of a cosine lobe is normalised like its albedo",
        ["pdf_mass"],
        PHONG,
        ScaledPdf,
        12.0 / 11.0
    ),
    wrapped!("flipped_pdf", "wo and wi change places in the pdf", ["chi2"], WIDE, FlippedPdf),
    wrapped!(
        "uniform_pdf",
        "cosine-weighted draws claim the uniform density",
        ["chi2", "uniformity"],
        LAMBERT,
        UniformPdf
    ),
    wrapped!("fresnel_in_pdf", "the pdf contains the Fresnel factor", ["pdf_mass"], LOBE, FresnelInPdf, 0.04),
    wrapped!("density_off", "the density in a sample is 0.1 % off pdf()", ["weight"], LAMBERT, DensityOff, 1.001),
    wrapped!("weight_off", "the weight is 0.1 % too large", ["weight", "convergence"], LAMBERT, WeightOff, 1.001),
    wrapped!("missing_cosine", "the weight lacks the cosine", ["weight"], LAMBERT, MissingCosine),
    wrapped!("clamped_cosine", "the cosine in the weight has 0.0001 added", ["weight"], LAMBERT, ClampedCosine),
    wrapped!(
        "rare_huge_weight",
        "one weight in ten thousand is a thousand times too large",
        ["weight"],
        LAMBERT,
        RareHugeWeight
    ),
    wrapped!("stale_weight", "the weight is that of the mirror direction", ["weight"], LOBE, StaleWeight),
    // Draws.
    wrapped!("dropped", "2 % of the draws are lost unannounced", ["pdf_mass", "chi2"], LOBE, Dropped, 0.02),
    wrapped!("hole", "0.1 % of the support is never drawn", ["chi2"], LOBE, Hole, 1e-3),
    wrapped!("leak", "0.1 % of the draws go where the pdf is almost 0", ["chi2"], "beckmann:alpha=0.1", Leak, 1e-3),
    wrapped!("rotated", "the sampler's axes are turned by 0.1 radians", ["chi2", "uniformity"], LOBE, Rotated, 0.1),
    wrapped!(
        "only_on_average",
        "right after averaging over the azimuth, and only then",
        ["chi2", "uniformity"],
        LOBE,
        OnlyOnAverage
    ),
    wrapped!(
        "mirrored_half_vector",
        "the half vector is on the wrong side of the normal",
        ["chi2"],
        LOBE,
        MirroredHalfVector
    ),
    wrapped!("unflipped_half_vector", "half of the draws point into the surface", ["chi2"], LOBE, UnflippedHalfVector),
    wrapped!("below_the_horizon", "draws that end below the horizon are kept", ["chi2"], WIDE, BelowTheHorizon),
    wrapped!(
        "redrawn",
        "lost draws are drawn again, and the pdf is not scaled up",
        ["pdf_mass", "chi2"],
        WIDE,
        Redrawn
    ),
    wrapped!("half_turn", "half of the azimuths are never drawn", ["chi2", "uniformity"], LAMBERT, HalfTurn),
    wrapped!(
        "missing_square_root",
        "the radius on the disk is u instead of √u",
        ["chi2", "uniformity"],
        LAMBERT,
        MissingSquareRoot
    ),
    wrapped!("correlated", "one random number serves for both coordinates", ["chi2"], LAMBERT, Correlated),
    wrapped!(
        "reused_uniform",
        "the number that picked the lobe is used again within it",
        ["chi2"],
        TWO_LOBES,
        ReusedUniform
    ),
    wrapped!(
        "biased_lobe",
        "sampler and pdf disagree about the lobes' probabilities",
        ["chi2"],
        TWO_LOBES,
        BiasedLobe,
        1.05
    ),
    // Of two models.
    chimera!(
        "swapped_axes",
        "the sampler takes one axis for the other",
        ["chi2"],
        "ggx:alpha_x=0.1,alpha_y=0.4",
        "ggx:alpha_x=0.1,alpha_y=0.4",
        "ggx:alpha_x=0.4,alpha_y=0.1"
    ),
    chimera!("squared_alpha", "the pdf squares alpha, the sampler does not", ["chi2"], LOBE, "ggx:alpha=0.09", LOBE),
    chimera!(
        "ndf_pdf",
        "visible normals are drawn, the pdf is that of all normals",
        ["chi2"],
        LOBE,
        "ggx:alpha=0.3,sampling=ndf",
        LOBE
    ),
    chimera!(
        "ggx_width_off",
        "the sampler's alpha is 1 % too large",
        ["chi2", "uniformity"],
        LOBE,
        LOBE,
        "ggx:alpha=0.303"
    ),
    chimera!(
        "beckmann_width_off",
        "the sampler's alpha is 1 % too small",
        ["chi2", "uniformity"],
        BECKMANN,
        BECKMANN,
        "beckmann:alpha=0.297"
    ),
    chimera!(
        "exponent_off",
        "the sampler's Phong exponent is 1 % too large",
        ["chi2", "uniformity"],
        PHONG,
        PHONG,
        "phong:n=10.1,kd=0,ks=0.8,norm=n+2"
    ),
    chimera!(
        "wrong_mixture",
        "the pdf weighs the parts of a mixture as another mixture does",
        ["chi2"],
        MIXTURE,
        "mix:a=(lambert:rho=0.8),b=(ggx:alpha=0.1),t=0.52",
        MIXTURE
    ),
    // Microfacets.
    unmatched!(
        "no_masking",
        "the masking is left out",
        ["energy_eye", "energy_light", "weak_white_furnace"],
        LOBE,
        GgxNormals,
        1.0,
        no_masking
    ),
    unmatched!(
        "rational_g1",
        "Beckmann with the rational fit of its masking",
        ["weak_white_furnace"],
        BECKMANN,
        BeckmannNormals,
        1.0,
        rational_beckmann
    ),
    unmatched!(
        "remapped_schlick",
        "k = (r+1)²/8 is the masking of no distribution",
        ["weak_white_furnace"],
        LOBE,
        GgxNormals,
        1.0,
        remapped_schlick
    ),
    unmatched!(
        "different_widths",
        "D and G take different alphas",
        ["weak_white_furnace"],
        LOBE,
        GgxNormals,
        1.0,
        rougher_ggx
    ),
    unmatched!(
        "unnormalised_d",
        "D is 0.1 % too large",
        ["weak_white_furnace", "pdf_mass"],
        LOBE,
        GgxNormals,
        1.001,
        ggx_masking
    ),
    wrapped!(
        "v_cavity_pdf",
        "the pdf has the masking of V-cavities, the sampler that of Smith",
        ["chi2"],
        LOBE,
        VCavityPdf
    ),
    wrapped!("nan_at_zero", "the logarithm of a uniform number that is 0", ["finite"], LAMBERT, NanAtZero),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::{CHECKS, Check, Effort, Outcome, Suite};
    use std::collections::{BTreeMap, BTreeSet};

    #[test]
    fn there_are_thirty_and_each_names_checks_that_exist() {
        let names: BTreeSet<&str> = twins().into_iter().map(|twin| twin.name).collect();
        assert_eq!(names.len(), twins().len(), "two twins have one name");
        assert!(names.len() >= 30);
        for twin in twins() {
            assert!(!twin.caught_by.is_empty());
            assert!(twin.caught_by.iter().all(|name| CHECKS.iter().any(|(check, _)| check == name)), "{}", twin.name);
        }
    }

    /// What `bsdf` gets from the check `name`, with the least effort that fails it.
    fn check(bsdf: &dyn Bsdf, name: &'static str, efforts: &[Effort]) -> Check {
        let run = |effort: &Effort| {
            let sheet = Suite { only: vec![name], effort: *effort, ..Suite::default() }.run(bsdf);
            sheet.check(name).cloned().unwrap()
        };
        let weaker = efforts[..efforts.len() - 1].iter().map(run).find(|check| check.outcome == Outcome::Fail);
        weaker.unwrap_or_else(|| run(efforts.last().unwrap()))
    }

    fn missed(efforts: &[Effort]) -> Vec<String> {
        let pairs = twins().into_iter().flat_map(|twin| twin.caught_by.iter().map(move |name| (twin, *name)));
        let found = pairs.map(|(twin, name)| (twin.name, check(&*(twin.broken)(), name, efforts)));
        let wrong = found.filter(|(_, check)| check.outcome != Outcome::Fail);
        wrong.map(|(twin, check)| format!("{twin}: {} says {}: {}", check.name, check.outcome, check.detail)).collect()
    }

    #[test]
    fn every_twin_is_rejected_by_the_checks_that_name_it() {
        let missed = missed(&[Effort::Quick, Effort::Default]);
        assert!(missed.is_empty(), "{missed:#?}");
    }

    #[test]
    #[ignore = "minutes"]
    fn every_twin_is_rejected_at_default_effort() {
        let missed = missed(&[Effort::Default]);
        assert!(missed.is_empty(), "{missed:#?}");
    }

    #[test]
    fn no_original_is_rejected_and_each_passes_what_rejects_its_twin() {
        let mut sheets = BTreeMap::new();
        for twin in twins() {
            let original = (twin.original)();
            let run = || Suite { effort: Effort::Quick, ..Suite::default() }.run(&*original);
            let sheet = sheets.entry(format!("{original:?}")).or_insert_with(run);
            assert_ne!(sheet.outcome(), Outcome::Fail, "{sheet:#?}");
            for name in twin.caught_by {
                // Off the full sheet only where the check has no object in the original either.
                let Some(check) = sheet.check(name) else { continue };
                assert_eq!(check.outcome, Outcome::Pass, "{}: {check:#?}", twin.name);
            }
        }
    }
}
