//! What a map says that it is wrong by, against what it is.

use glam::{DVec2, DVec3};

use super::{build, floor, grey, named, shoot};
use crate::math::color::Rgb;
use crate::math::sum::Moments;
use crate::render::photon::gather::FinalGather;
use crate::render::photon::kernel::Estimator;
use crate::render::photon::map::{Around, Gather, PhotonMap};
use crate::render::photon::shoot::Shooting;
use crate::render::photon::stated::{OfMap, Stated, map_errors};
use crate::render::photon::view::DirectView;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::{Light, Ray, Scene};

/// Means of many samples along rays from one point, over maps, and the deviations that are stated.
fn over_maps(scene: &Scene, maps: u64, light: impl Fn(u64) -> Box<dyn OfMap>) -> (Moments, Moments) {
    let (mut values, mut stated) = (Moments::default(), Moments::default());
    for seed in 0..maps {
        let light = light(seed);
        let (mut sampler, mut sum) = (Independent::new(seed), Stated::default());
        for sample in 0..200 {
            sampler.begin(0, sample);
            // One point of the wall.
            let ray = scene.camera_ray(DVec2::splat(256.5), DVec2::ZERO);
            sum += light.stated(scene, ray, &mut sampler);
        }
        values.add(sum.value.mean() / 200.0);
        stated.add(sum.std_err / 200.0);
    }
    (values, stated)
}

#[test]
fn the_deviation_over_maps_is_the_one_that_is_stated_and_below_it_where_many_points_are_gathered() {
    let scene = named("furnace-sphere", &[]);
    let around = Around::Nearest { k: 40, reach: f64::INFINITY };
    let gather = Gather { around, ..Gather::default() };
    let shot = |seed| Shooting { photons: 5000, seed, ..Shooting::default() }.shoot(&scene).unwrap().photons;
    let (values, stated) = over_maps(&scene, 300, |seed| {
        Box::new(DirectView::new(PhotonMap::new(&scene, &shot(seed), gather).unwrap(), None))
    });
    let ratio = stated.mean() / values.variance().sqrt();
    // A deviation from 300 values is known to 4 %: 4 sigma; the mean of a root is 1 / (8 k) below the root of the mean.
    assert!((ratio - 1.0).abs() <= 0.16, "{ratio}");
    let (values, stated) =
        over_maps(&scene, 100, |seed| Box::new(FinalGather::new(&scene, &shot(seed), gather, 4, None).unwrap()));
    // 800 rays meet most of the map's photons, so that what is common to them is the number of photons alone.
    let ratio = stated.mean() / values.variance().sqrt();
    assert!(ratio >= 1.0, "{ratio}");
}

#[test]
fn the_bias_of_what_is_seen_is_stated_and_what_is_emitted_has_none() {
    // Under a point light E = I h / (h² + ρ²)^(3/2): bent downwards at its foot.
    let (h, rho, radius) = (0.5_f64, 0.6, 0.2);
    let lights = vec![Light::Point { position: DVec3::new(0.5, 0.5, h), intensity: Rgb::WHITE }];
    let scene = build(vec![grey(rho)], vec![floor(0)], lights);
    let ray = Ray::new(DVec3::new(0.5, 0.5, 0.2), -DVec3::Z);
    let exact = rho / std::f64::consts::PI / (h * h);
    let gather = Gather { around: Around::Radius(radius), estimator: Estimator::KMinusOne, ..Gather::default() };
    let (mut values, mut stated, mut sampler) = (Moments::default(), Moments::default(), Independent::new(1));
    for seed in 0..60 {
        let shot = Shooting { photons: 40_000, seed, ..Shooting::default() }.shoot(&scene).unwrap();
        let view = DirectView::new(PhotonMap::new(&scene, &shot.photons, gather).unwrap(), Some(1));
        let seen = view.stated(&scene, ray, &mut sampler);
        values.add(seen.value.mean());
        stated.add(seen.bias.mean());
    }
    let bias = values.mean() - exact;
    // 4 sigma of both, and the field's next order, R²/h² of the leading one.
    let allowed = 4.0 * values.std_err().hypot(stated.std_err()) + 0.16 * bias.abs();
    assert!((stated.mean() - bias).abs() <= allowed, "{} against {bias}", stated.mean());
    assert!(bias < -0.05 * exact, "there must be a bias to be seen");

    let furnace = named("furnace-sphere", &[("rho", "0")]).with_size(2, 2);
    let view = DirectView::new(PhotonMap::new(&furnace, &shoot(&furnace, 1000).photons, gather).unwrap(), None);
    assert_eq!(map_errors(&furnace, &view, 2, 1), [vec![0.0; 4], vec![0.0; 4]]);
}
