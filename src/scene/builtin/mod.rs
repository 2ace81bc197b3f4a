//! Scenes that need no file, by name: the Cornell boxes in use, and scenes whose answer is known in closed form.
//!
//! There are several incompatible Cornell boxes. Each has its own name here, so that a result says which it is of.

mod bitterli;
mod cornell;
mod enclosure;
mod lights;
mod parts;
mod veach;

pub use enclosure::{furnace_radiance, sphere_multiplier};

use super::SceneDescription;
use crate::bsdf::subject::{Args, ParamSpec, SubjectError, nearest_name};

/// A built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// The name by which it is asked for.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub summary: &'static str,
    /// What may be set.
    pub params: &'static [ParamSpec],
    /// What is known about its image in closed form.
    pub closed_form: Option<&'static str>,
    build: fn(&Args) -> Result<SceneDescription, SubjectError>,
}

#[rustfmt::skip] // One a line.
static SCENES: &[Builtin] = &[
    cornell::ORIGINAL,
    cornell::MITSUBA,
    bitterli::CORNELL,
    veach::MIS,
    enclosure::FURNACE_SPHERE,
    enclosure::FURNACE_BOX,
    enclosure::INTEGRATING_SPHERE,
    enclosure::CUBE_ONE_EMITTER,
    lights::SPHERE_LIGHT,
    lights::UNIT_SQUARE_LIGHT,
];

/// All built-in scenes, in the order in which they are shown.
pub fn list() -> &'static [Builtin] {
    SCENES
}

/// The built-in scene called `name` with these parameters; None where there is none of that name.
pub fn builtin(name: &str, params: &[(String, String)]) -> Option<Result<SceneDescription, SubjectError>> {
    let scene = SCENES.iter().find(|scene| scene.name == name)?;
    let pairs = params.iter().map(|(key, value)| (key.as_str(), value.as_str()));
    Some(Args::from_pairs(scene.name, scene.params, pairs).and_then(|args| (scene.build)(&args)))
}

/// "did you mean X?" for the built-in scene of the nearest name, else all names.
pub fn nearest(name: &str) -> String {
    nearest_name(name, SCENES.iter().map(|scene| scene.name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn pair(key: &str, value: &str) -> (String, String) {
        (key.into(), value.into())
    }

    #[test]
    fn every_scene_can_be_built_under_its_own_name() {
        for scene in list() {
            let description = builtin(scene.name, &[]).unwrap().unwrap();
            assert_eq!(description.name, scene.name);
            let built = Scene::new(description).unwrap();
            assert!(!built.emitters().is_empty(), "{}", scene.name);
            let ray = built.camera_ray(glam::DVec2::new(1.0, 1.0), glam::DVec2::ZERO);
            assert!(ray.origin.is_finite() && (ray.dir.length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_bad_parameter_is_one_clear_line() {
        let error = |params: &[(String, String)]| builtin("furnace-sphere", params).unwrap().unwrap_err().to_string();
        assert_eq!(error(&[pair("roh", "0.5")]), "furnace-sphere: no parameter roh; did you mean rho?");
        assert_eq!(
            error(&[pair("rho", "1.5")]),
            "furnace-sphere: rho = 1.5 is not allowed; allowed is a number or r/g/b, each in [0, 1]"
        );
        assert!(error(&[pair("rho", "0.5"), pair("rho", "0.5")]).contains("given twice"));
        assert!(error(&[pair("rho", "half")]).contains("not allowed"));
        let none = builtin("veach-mis", &[pair("rho", "1")]).unwrap().unwrap_err().to_string();
        assert_eq!(none, "veach-mis: no parameter rho; there are none");
        assert!(builtin("cornell", &[]).is_none() && nearest("furnace-spere").contains("furnace-sphere"));
    }
}
