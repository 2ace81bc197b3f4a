//! Patches that are finer where the light changes, against as many equal ones.

use whitefurnace::glam::DVec2;
use whitefurnace::math::color::Rgb;
use whitefurnace::render::radiosity::hierarchical::Hierarchical;
use whitefurnace::render::radiosity::model::{Radiosity, SolvedScene};
use whitefurnace::render::radiosity::patches::{Fineness, Patches};
use whitefurnace::scene::{Ray, Scene};

use crate::common::named;

/// Root mean square difference by area, relative to what is reflected, over the patches of `fine`, each by its centre.
fn distance(scene: &Scene, fine: &Patches, exact: &[Rgb], found: &SolvedScene) -> f64 {
    let (mut gap, mut sum) = (0.0, 0.0);
    for (patch, b) in fine.all().iter().zip(exact) {
        let (p, n) = patch.form.at(DVec2::splat(0.5));
        let ray = Ray::new(p + n * (1e-6 * fine.extent()), -n);
        let Some(other) = scene.intersect(&ray).and_then(|surface| found.patches.at(&surface, n)) else { continue };
        gap += patch.area * (*b - found.solved.radiosity[other]).0.length_squared();
        sum += patch.area * (*b - patch.emission).0.length_squared();
    }
    (gap / sum).sqrt()
}

#[test]
fn finer_patches_where_the_light_changes_are_better_than_as_many_equal_ones() {
    let scene = named("cornell-original", &[]);
    // .5 % and elements of a fifth of the length: far below what either is off.
    let fine = Hierarchical { fineness: Fineness::Count(12_000), error: 0.005, ..Hierarchical::default() };
    let fine = fine.solve(&scene).expect("a solution");
    for count in [300, 600] {
        let [equal, adaptive] = [false, true].map(|adaptive| {
            let model = Radiosity { fineness: Fineness::Count(count), adaptive, ..Radiosity::default() };
            model.solve(&scene).expect("a solution")
        });
        let numbers = [&equal, &adaptive].map(|found| found.patches.all().len());
        let [even, better] =
            [&equal, &adaptive].map(|found| distance(&scene, &fine.patches, &fine.solved.radiosity, found));
        assert!(numbers[1] <= numbers[0] + numbers[0] / 20, "{numbers:?}");
        // Less than a seventh would not be worth the solutions that it takes.
        assert!(better < 0.85 * even, "{count}: {better} against {even}");
    }
}
