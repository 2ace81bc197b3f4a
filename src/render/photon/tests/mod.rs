//! Photon maps against what is known in closed form, and against path tracing.

mod density;
mod glass;
mod lights;
mod paths;
mod rooms;
mod stated;

use std::sync::Arc;

use glam::DVec3;

use crate::math::color::Rgb;
use crate::render::photon::PhotonError;
use crate::render::photon::gather::FinalGather;
use crate::render::photon::map::{Around, Gather, PhotonMap};
use crate::render::photon::shoot::{Shooting, Shot};
use crate::sampling::filter::Filter;
use crate::scene::builtin::builtin;
use crate::scene::{
    Camera, FilmSettings, Geometry, Light, Material, Mesh, RenderSettings, Scene, SceneDescription, Shape,
};

fn quad(corners: [DVec3; 4]) -> Geometry {
    Geometry::Mesh(Arc::new(Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap()))
}

fn shape(name: &str, geometry: Geometry, material: usize) -> Shape {
    Shape { name: name.into(), geometry, flip_normals: false, material, emission: None }
}

fn build(materials: Vec<Material>, shapes: Vec<Shape>, lights: Vec<Light>) -> Scene {
    Scene::new(SceneDescription {
        name: "photons".into(),
        camera: Camera::look_at(DVec3::new(0.3, 0.4, 3.0), DVec3::new(0.3, 0.4, 0.0), DVec3::Y, 60.0),
        film: FilmSettings { width: 8, height: 8, filter: Filter::BOX },
        render: RenderSettings::default(),
        materials,
        shapes,
        lights,
    })
    .unwrap()
}

fn grey(rho: f64) -> Material {
    Material::diffuse("grey", Rgb::grey(rho).into())
}

fn named(name: &str, params: &[(&str, &str)]) -> Scene {
    let params: Vec<_> = params.iter().map(|(key, value)| ((*key).into(), (*value).into())).collect();
    Scene::new(builtin(name, &params).unwrap().unwrap()).unwrap()
}

fn shoot(scene: &Scene, photons: u64) -> Shot {
    Shooting { photons, ..Shooting::default() }.shoot(scene).unwrap()
}

/// The unit square at z = 0, seen from above.
fn floor(material: usize) -> Shape {
    shape("floor", quad([DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]), material)
}

#[test]
fn what_cannot_be_is_one_clear_error() {
    let dark = build(vec![grey(0.5)], vec![floor(0)], vec![]);
    assert_eq!(Shooting::default().shoot(&dark).unwrap_err(), PhotonError::NoLight);
    let scene = named("furnace-box", &[]);
    let none = Shooting { photons: 0, ..Shooting::default() };
    assert_eq!(none.shoot(&scene).unwrap_err(), PhotonError::NoPhotons);
    let endless = named("furnace-box", &[("rho", "1")]);
    let few = Shooting { photons: 2000, most: 10_000, ..Shooting::default() };
    assert_eq!(few.shoot(&endless).unwrap_err(), PhotonError::TooMany { most: 10_000 });
    let shot = shoot(&scene, 10);
    let stored = shot.photons.len();
    let map = |around| PhotonMap::new(&scene, &shot.photons, Gather { around, ..Gather::default() });
    let nearest = |k| Around::Nearest { k, reach: f64::INFINITY };
    assert_eq!(map(nearest(1000)).unwrap_err(), PhotonError::TooFew { k: 1000, stored });
    assert!(matches!(map(nearest(1)).unwrap_err(), PhotonError::NoNeighbours { k: 1, least: 2, .. }));
    for radius in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(map(Around::Radius(radius)).unwrap_err(), PhotonError::Radius(radius));
    }
    assert!(map(Around::Radius(f64::NAN)).is_err());
    assert!(FinalGather::new(&scene, &shot.photons, Gather::default(), 0, None).is_err());
}
