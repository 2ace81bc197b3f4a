//! The reflectance of patches, and what cannot have one.

use glam::DVec2;
use std::f64::consts::FRAC_1_PI;

use super::RadiosityError;
use super::face::Face;
use super::patch::Form;
use super::patches::Materials;
use crate::bsdf::Uniforms;
use crate::math::color::Rgb;
use crate::sampling::sampler::{Independent, Sampler};
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::{LocalBsdf, Material, Scene};

/// Points along each side of a patch at which a reflectance that varies is looked up.
const LOOKS: u32 = 4;
/// Draws by which a model that is not diffuse is approximated: its albedo is then known to about a hundredth of its spread.
const DRAWS: u64 = 1 << 14;

/// The reflectance of a material.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reflectance {
    /// The same everywhere.
    Even(Rgb),
    /// To be averaged over each patch.
    Varying,
}

impl Reflectance {
    /// Of every material that a shape is made of.
    pub(super) fn of_all(scene: &Scene, materials: Materials) -> Result<Vec<Self>, RadiosityError> {
        let each = scene.materials().iter().enumerate();
        let each = each.map(|(number, material)| {
            let used = scene.shapes().iter().find(|shape| shape.material == number);
            used.map_or(Ok(Self::Even(Rgb::BLACK)), |shape| Self::of(material, &shape.name, materials))
        });
        each.collect()
    }

    fn of(material: &Material, shape: &str, materials: Materials) -> Result<Self, RadiosityError> {
        let name = || (material.name().to_string(), shape.to_string());
        if material.opacity().is_some() {
            let (material, shape) = name();
            return Err(RadiosityError::Masked { material, shape });
        }
        let reflectance = match material.lambertian() {
            Some(rho) => Self::Even(rho),
            None if material.is_diffuse() => Self::Varying,
            None if materials == Materials::Diffuse => {
                let (material, shape) = name();
                return Err(RadiosityError::NotDiffuse { material, shape });
            }
            None if material.varies() => Self::Varying,
            None => Self::Even(albedo(&material.at(DVec2::splat(0.5), Rgb::WHITE))),
        };
        match reflectance {
            Self::Even(rho) if !(rho.is_finite() && rho.max_channel() < 1.0) => {
                let (material, shape) = name();
                Err(RadiosityError::TooReflective { material, shape, reflectance: rho })
            }
            reflectance => Ok(reflectance),
        }
    }

    /// Of a patch.
    pub(super) fn over(self, scene: &Scene, face: &Face, form: &Form) -> Rgb {
        if let Self::Even(rho) = self {
            return rho;
        }
        let material = scene.material_of(face.shape);
        let looks = (0..LOOKS * LOOKS).map(|i| {
            let u = (DVec2::new(f64::from(i % LOOKS), f64::from(i / LOOKS)) + 0.5) / f64::from(LOOKS);
            let (p, _) = form.at(u);
            let surface = scene.surface_at(face.primitives, p);
            let local = material.at(surface.uv, surface.color);
            if material.is_diffuse() { local.eval(glam::DVec3::Z, glam::DVec3::Z) / FRAC_1_PI } else { albedo(&local) }
        });
        let mean = looks.sum::<Rgb>() / f64::from(LOOKS * LOOKS);
        // A picture may be whiter than anything; what is solved must lose a little at each reflection.
        mean.map(|rho| rho.clamp(0.0, WHITEST))
    }
}

/// The largest reflectance of a patch whose material varies.
const WHITEST: f64 = 0.999;

/// The share of even light from above that the model sends back above: the mean weight of its draws from a direction drawn by
/// the cosine.
fn albedo(model: &LocalBsdf) -> Rgb {
    let mut sum = Rgb::BLACK;
    for i in 0..DRAWS {
        let mut numbers = Independent::at(0, 0, i);
        // Strata along the elevation, on which an albedo depends most.
        let u = DVec2::new((i as f64 + numbers.next_1d()) / DRAWS as f64, numbers.next_1d());
        let uniforms = Uniforms { lobe: numbers.next_1d(), dir: numbers.next_2d() };
        if let Some(draw) = model.sample(cosine_hemisphere(u), uniforms).filter(|draw| draw.wi.z > 0.0) {
            sum += draw.weight;
        }
    }
    sum / DRAWS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Ggx, Phong, PhongNorm};

    #[test]
    fn a_phong_lobe_is_projected_to_its_albedo() {
        let phong = Phong::new(20.0, 0.3, 0.5, PhongNorm::AlbedoNPlus2).unwrap();
        // The integrator knows it to 1e-6.
        let exact = crate::integrate::Hemisphere::default().average(&phong, crate::integrate::Side::Eye).value;
        let material = Material::uniform("phong", Box::new(phong));
        let found = albedo(&material.at(DVec2::ZERO, Rgb::WHITE));
        // A spread of at most 1 over 2^14 draws: five standard errors.
        assert!((found - exact).0.abs().max_element() < 5.0 / (DRAWS as f64).sqrt(), "{found} against {exact}");
    }

    #[test]
    fn a_glossy_material_is_refused_by_name_or_projected() {
        let gold = || Material::ggx("gold", Ggx::new(0.3).unwrap());
        let refused = Reflectance::of(&gold(), "knob", Materials::Diffuse).unwrap_err().to_string();
        assert!(refused.contains("gold") && refused.contains("knob"), "{refused}");
        let Reflectance::Even(rho) = Reflectance::of(&gold(), "knob", Materials::Approximated).unwrap() else {
            panic!("it is the same everywhere")
        };
        // A mirror-like metal of reflectance 1 loses what bounces more than once between its facets.
        assert!(rho.max_channel() > 0.8 && rho.max_channel() < 1.0, "{rho}");
    }

    #[test]
    fn what_reflects_everything_is_refused() {
        let white = Material::diffuse("white", Rgb::WHITE.into());
        let refused = Reflectance::of(&white, "wall", Materials::Diffuse).unwrap_err().to_string();
        assert!(refused.contains("white") && refused.contains("below 1"), "{refused}");
    }
}
