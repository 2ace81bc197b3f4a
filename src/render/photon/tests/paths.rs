//! Images of the Cornell box against path tracing.

use glam::DVec2;

use super::named;
use crate::math::sum::Moments;
use crate::render::Radiance;
use crate::render::path::PathTracer;
use crate::render::photon::Kept;
use crate::render::photon::gather::FinalGather;
use crate::render::photon::kernel::Estimator;
use crate::render::photon::map::{Around, Gather, PhotonMap};
use crate::render::photon::progressive::{ALPHA, First, Sppm};
use crate::render::photon::shoot::Shooting;
use crate::render::photon::view::DirectView;
use crate::sampling::sampler::{Independent, Sampler};
use crate::scene::Scene;

/// Block means of the image by one algorithm.
fn blocks(scene: &Scene, light: &dyn Radiance, samples: u64, seed: u64) -> Vec<Moments> {
    use rayon::prelude::*;
    (0..256_u64)
        .into_par_iter()
        .map(|block| {
            let mut moments = Moments::default();
            let mut sampler = Independent::new(seed);
            for sample in 0..samples {
                sampler.begin(block, sample);
                let at = sampler.next_2d() + DVec2::new((block % 16) as f64, (block / 16) as f64);
                let ray = scene.camera_ray(32.0 * at, DVec2::ZERO);
                moments.add(light.radiance(scene, ray, &mut sampler).mean());
            }
            moments
        })
        .collect()
}

#[test]
fn progressive_maps_of_the_cornell_box_come_to_path_tracing() {
    let scene = named("cornell-original", &[]);
    let paths = blocks(&scene, &PathTracer::default(), 1500, 1);
    let total = |blocks: &[Moments]| blocks.iter().map(Moments::mean).sum::<f64>();
    let shooting = Shooting { photons: 10_000, ..Shooting::default() };
    let plan = Sppm::new(&scene, shooting, (First::Holds(40), Estimator::KMinusOne), ALPHA, None).unwrap();
    let mut means = Moments::default();
    for pass in 0..40 {
        means.add(total(&blocks(&scene, &plan.pass(&scene, pass).unwrap(), 8, pass + 100)) / total(&paths));
    }
    // Noise to 4 sigma; blurred over radii of 3 % of the room, the light of the whole image loses less than 1 % at outlines.
    assert!((means.mean() - 1.0).abs() <= 4.0 * means.std_err() + 0.01, "{means:?}");
    // The twin: direct light counted twice, by photons as well as by connection.
    let twice = Shooting { kept: Kept::Global, ..shooting }.shoot(&scene).unwrap();
    let around = Around::Radius(plan.radius(0));
    let map = PhotonMap::new(&scene, &twice.photons, Gather { around, ..Gather::default() }).unwrap();
    let all = total(&blocks(&scene, &DirectView::new(map, None), 100, 5)) / total(&paths);
    let direct =
        total(&blocks(&scene, &PathTracer { bounces: Some(1), ..PathTracer::default() }, 500, 6)) / total(&paths);
    let emitted =
        total(&blocks(&scene, &PathTracer { bounces: Some(0), ..PathTracer::default() }, 500, 7)) / total(&paths);
    assert!((all + direct - emitted - 1.0).abs() > 0.1, "the comparison has lost its power");
}

#[test]
fn rays_of_a_gather_are_spread_better_than_by_chance() {
    // A point of the ceiling, to which no light comes straight: all is by the rays, to one map.
    let scene = named("cornell-original", &[]);
    let ray = scene.camera_ray(DVec2::new(256.0, 40.0), DVec2::ZERO);
    let met = scene.intersect(&ray).expect("the ceiling");
    assert_eq!(scene.shapes()[met.shape].name, "ceiling");
    let shot = Shooting { photons: 50_000, ..Shooting::default() }.shoot(&scene).unwrap();
    let [one, many] = [1, 16].map(|rays| {
        let light = FinalGather::new(&scene, &shot.photons, Gather::default(), rays, None).unwrap();
        let (mut moments, mut sampler) = (Moments::default(), Independent::new(2));
        for sample in 0..16_000 {
            sampler.begin(0, sample);
            moments.add(light.radiance(&scene, ray, &mut sampler).mean());
        }
        moments
    });
    let gap = (one.mean() - many.mean()).abs();
    assert!(gap <= 4.0 * one.std_err().hypot(many.std_err()), "{one:?} {many:?}");
    // Sixteen independent rays would leave a sixteenth of the variance, each of the two known to 2 %; a lattice leaves less, as far as the
    // light is smooth: the map's own grain stays.
    let ratio = 16.0 * many.variance() / one.variance();
    assert!(ratio < 0.9, "{ratio}");
}
