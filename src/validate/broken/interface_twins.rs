//! The table of twins with transmission, with Dirac lobes, and with light below the surface.

use super::twins::{Twin, model, wrapped};
use super::{
    BiasedLobe, CarriesRadiance, DiracProbabilityOff, FreeExit, GainFromBelow, InverseSnell, OneWay,
    ReflectionJacobian, SameIndexInside, SignedCosine, SqueezedBeam, UnsharedPdf, WeightOff,
};

const ROUGH: &str = "rough-dielectric:alpha=0.3";
const GLASS: &str = "dielectric:eta=1.5";
const PLASTIC: &str = "plastic:rho=1,eta=1.5";

pub(super) static TWINS: &[Twin] = &[
    // Rough glass.
    wrapped!(
        "rough_radiance",
        "f carries L in place of L/η², and light gets brighter on its way out",
        ["reciprocity", "energy_eye", "energy_light"],
        ROUGH,
        CarriesRadiance
    ),
    wrapped!("same_index_inside", "from inside, η is taken for 1/η", ["reciprocity"], ROUGH, SameIndexInside),
    wrapped!(
        "reflection_jacobian",
        "the pdf of what is refracted has the 1 / (4 wo·m) of reflection",
        ["pdf_mass", "chi2"],
        ROUGH,
        ReflectionJacobian
    ),
    wrapped!(
        "glass_lobe_probability",
        "sampler and pdf disagree about the probability of reflection",
        ["chi2"],
        ROUGH,
        BiasedLobe,
        1.05
    ),
    wrapped!("signed_cosine", "the weight has wi.z in place of |wi.z|", ["finite", "weight"], ROUGH, SignedCosine),
    // Dirac lobes.
    wrapped!(
        "glass_gains",
        "smooth glass returns 0.01 % more than it receives",
        ["energy_eye", "energy_light", "white_furnace"],
        GLASS,
        WeightOff,
        1.0001
    ),
    wrapped!(
        "dirac_radiance",
        "the weight of refraction carries L in place of L/η²",
        ["reciprocity", "energy_eye", "energy_light"],
        GLASS,
        CarriesRadiance
    ),
    wrapped!(
        "dirac_probability",
        "a Dirac lobe claims a probability that is 1 % too large",
        ["pdf_mass", "convergence"],
        GLASS,
        DiracProbabilityOff,
        1.01
    ),
    wrapped!("inverse_snell", "light is refracted with the inverse index", ["reciprocity"], GLASS, InverseSnell),
    wrapped!(
        "squeezed_beam",
        "the shares of both ways agree, but a beam comes out narrower without getting brighter",
        ["reciprocity"],
        "null",
        SqueezedBeam,
        0.9
    ),
    wrapped!("one_way", "light passes downwards only", ["reciprocity", "white_furnace"], "null", OneWay),
    // A coat over a base.
    wrapped!(
        "free_exit",
        "the base is seen through the coat, but lit as if there were none",
        ["reciprocity", "energy_eye", "white_furnace"],
        PLASTIC,
        FreeExit,
        1.5
    ),
    wrapped!(
        "unshared_pdf",
        "the pdf of the diffuse lobe lacks the probability of drawing it",
        ["pdf_mass", "chi2"],
        PLASTIC,
        UnsharedPdf
    ),
    // Below the surface.
    wrapped!(
        "gain_from_below",
        "f is 0.01 % too large where it is seen from below",
        ["energy_eye", "energy_light", "white_furnace"],
        "two-sided:front=(lambert:rho=1)",
        GainFromBelow,
        1.0001
    ),
];
