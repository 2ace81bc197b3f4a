//! What all points have in common, and what each promises; with twins that must be seen.

use glam::DVec2;

use super::hash::{carried, mix};
use super::{Halton, Jittered, Lattice, Sobol};
use crate::sampling::sampler::{Sampler, SamplerKind};

/// The pairs of number `pair` of so many samples.
fn pairs(sampler: &mut dyn Sampler, samples: u64, pair: usize) -> Vec<DVec2> {
    pairs_of_pixel(sampler, 5, samples, pair)
}

fn pairs_of_pixel(sampler: &mut dyn Sampler, pixel: u64, samples: u64, pair: usize) -> Vec<DVec2> {
    let one = |i| {
        sampler.begin(pixel, i);
        (0..pair).for_each(|_| {
            sampler.next_1d();
        });
        sampler.next_2d()
    };
    (0..samples).map(one).collect()
}

/// Whether every cell of a grid holds exactly `share` points.
fn is_even(points: &[DVec2], columns: usize, rows: usize, share: usize) -> bool {
    let mut counts = vec![0; columns * rows];
    for p in points {
        let (x, y) = ((p.x * columns as f64) as usize, (p.y * rows as f64) as usize);
        counts[y * columns + x] += 1;
    }
    counts.iter().all(|&count| count == share)
}

/// Whether all elementary intervals of 2^k points hold one of them each.
fn is_net(points: &[DVec2]) -> bool {
    let k = points.len().ilog2();
    (0..=k).all(|i| is_even(points, 1 << i, 1 << (k - i), 1))
}

#[test]
fn powers_of_two_of_sobols_points_are_nets_in_every_pair() {
    for seed in 0..20 {
        for pair in 0..4 {
            for k in [0, 1, 4, 8, 10] {
                assert!(is_net(&pairs(&mut Sobol::new(seed), 1 << k, pair)), "seed {seed}, pair {pair}, 2^{k}");
            }
        }
        // The next 2^k of them too.
        assert!(is_net(&pairs(&mut Sobol::new(seed), 512, 1)[256..]));
    }
    // Twins: one point is repeated; grids of another kind are no nets.
    let mut repeated = pairs(&mut Sobol::new(1), 256, 0);
    repeated[7] = repeated[8];
    assert!(!is_net(&repeated));
    assert!(!is_net(&pairs(&mut Jittered::new(1, 256), 256, 0)));
}

#[test]
fn jittered_points_have_a_cell_each() {
    for seed in 0..20 {
        for pair in 0..3 {
            let points = pairs(&mut Jittered::new(seed, 144), 288, pair);
            assert!(
                is_even(&points[..144], 12, 12, 1) && is_even(&points[144..], 12, 12, 1),
                "seed {seed}, pair {pair}"
            );
        }
        let mut sampler = Jittered::new(seed, 100);
        let single: Vec<DVec2> = (0..100)
            .map(|i| {
                sampler.begin(2, i);
                DVec2::new(sampler.next_1d(), 0.0)
            })
            .collect();
        assert!(is_even(&single, 100, 1, 1));
    }
    assert!(!is_even(&pairs(&mut SamplerKind::Independent.sampler(1, 144, 1), 144, 0), 12, 12, 1));
}

#[test]
fn multi_jittered_points_have_an_interval_each_too() {
    for seed in 0..20 {
        for pair in 0..3 {
            let points = pairs(&mut Jittered::multi(seed, 144), 144, pair);
            for (columns, rows) in [(12, 12), (144, 1), (1, 144)] {
                assert!(is_even(&points, columns, rows, 1), "seed {seed}, pair {pair}, {columns} x {rows}");
            }
        }
    }
    assert!(!is_even(&pairs(&mut Jittered::new(1, 144), 144, 0), 144, 1, 1), "plainly jittered ones have not");
}

#[test]
fn haltons_points_are_even_in_the_powers_of_their_bases() {
    for seed in 0..20 {
        let points = pairs(&mut Halton::new(seed, 144), 144, 0);
        for (columns, rows) in [(16, 9), (8, 3), (4, 9), (16, 1), (1, 9)] {
            assert!(is_even(&points, columns, rows, 144 / (columns * rows)), "seed {seed}, {columns} x {rows}");
        }
        // Bases 3 and 5, and 2 and 3 again after the last.
        assert!(is_even(&pairs(&mut Halton::new(seed, 225), 225, 1), 9, 25, 1), "seed {seed}");
        assert!(is_even(&pairs(&mut Halton::new(seed, 144), 144, 64), 16, 9, 1), "seed {seed}");
    }
    assert!(!is_even(&pairs(&mut Halton::new(1, 144), 144, 1), 16, 9, 1), "other bases");
}

#[test]
fn a_lattice_has_one_point_in_each_interval_and_keeps_its_distance() {
    let closest = |points: &[DVec2]| {
        let around = |d: DVec2| (d - d.round()).length();
        let pairs = points.iter().enumerate().flat_map(|(i, p)| points[..i].iter().map(move |q| around(*p - *q)));
        pairs.fold(f64::INFINITY, f64::min)
    };
    for seed in 0..20 {
        for pair in 0..3 {
            // The second half of a sequence too.
            for points in pairs(&mut Lattice::new(seed), 128, pair).chunks(64) {
                assert!(is_even(points, 64, 1, 1) && is_even(points, 1, 64, 1), "seed {seed}, pair {pair}");
                // No 64 points in the unit square keep more than 1.0746 / √64 from each other, and these more than .88 of it.
                assert!((0.118..0.1344).contains(&closest(points)), "seed {seed}, pair {pair}: {}", closest(points));
            }
        }
    }
    assert!(closest(&pairs(&mut Sobol::new(1), 64, 0)) < 0.1, "another kind of points");
}

#[test]
fn neighbouring_pixels_share_a_net() {
    // Pixels of a square of 4 x 4, in an image 24 pixels wide, 16 samples each.
    let share_nets = |sampler: &mut dyn Sampler, pair: usize| {
        let mut of_square = |side: u64| -> Vec<DVec2> {
            let pixels = (0..side * side).map(|i| (8 + i / side) * 24 + 20 + i % side);
            pixels.flat_map(|pixel| pairs_of_pixel(sampler, pixel, 16, pair)).collect()
        };
        is_net(&of_square(1)) && is_net(&of_square(2)) && is_net(&of_square(4))
    };
    for seed in 0..20 {
        for pair in 0..3 {
            assert!(share_nets(&mut Sobol::over_pixels(seed, 16, 24), pair), "seed {seed}, pair {pair}");
        }
    }
    assert!(!share_nets(&mut Sobol::new(1), 0), "each pixel for itself");
    assert!(!share_nets(&mut Sobol::over_pixels(1, 16, 23), 0), "another width");
    // Samples beyond those that were planned are another net.
    let mut sampler = Sobol::over_pixels(3, 16, 24);
    let both = pairs_of_pixel(&mut sampler, 7, 32, 0);
    assert!(is_net(&both[..16]) && is_net(&both[16..]));
}

#[test]
fn every_value_is_uniform_over_the_seeds() {
    // In 64 parts, 20 000 seeds: chi-square of 63 degrees of freedom. 140 is exceeded with probability 1e-7.
    let chi2 = |value: &dyn Fn(u64) -> f64| {
        let mut counts = [0.0; 64];
        for seed in 0..20_000 {
            let u = value(seed);
            assert!((0.0..1.0).contains(&u), "{u}");
            counts[(u * 64.0) as usize] += 1.0;
        }
        counts.iter().map(|count| (count - 312.5_f64).powi(2) / 312.5).sum::<f64>()
    };
    for &(name, kind) in SamplerKind::ALL {
        for index in [0, 3, 60] {
            let at = |seed: u64| {
                let mut sampler = kind.sampler(seed, 61, 16);
                sampler.begin(9, index);
                sampler
            };
            let found = [
                chi2(&|seed| at(seed).next_1d()),
                chi2(&|seed| at(seed).next_2d().x),
                chi2(&|seed| at(seed).next_2d().y),
                // The digits below those of the grid.
                chi2(&|seed| (at(seed).next_2d().y * 4_294_967_296.0).fract()),
            ];
            assert!(found.iter().all(|&chi2| chi2 < 140.0), "{name}, sample {index}: {found:?}");
        }
    }
    assert!(chi2(&|seed| Sobol::new(seed).next_1d() * 0.99) > 140.0, "a value that is a percent too small is not seen");
}

#[test]
fn numbers_of_one_sample_are_independent_of_each_other() {
    const SEEDS: u64 = 20_000;
    // All pairs of a single, two pairs and another single, in 8 x 8 cells: 15 χ² of 63 degrees of freedom, for each sampler.
    let chi2 = |numbers: &dyn Fn(u64) -> [f64; 6]| {
        let mut worst = 0.0_f64;
        let drawn: Vec<[f64; 6]> = (0..SEEDS).map(numbers).collect();
        for i in 0..6 {
            for j in 0..i {
                let mut counts = [0.0; 64];
                for u in &drawn {
                    counts[(u[i] * 8.0) as usize * 8 + (u[j] * 8.0) as usize] += 1.0;
                }
                let expected = SEEDS as f64 / 64.0;
                worst = worst.max(counts.iter().map(|n| (n - expected) * (n - expected) / expected).sum());
            }
        }
        worst
    };
    for &(name, kind) in SamplerKind::ALL {
        for index in [0, 3, 60] {
            let found = chi2(&|seed| {
                let mut sampler = kind.sampler(seed, 61, 16);
                sampler.begin(9, index);
                let (first, p, q) = (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
                [first, p.x, p.y, q.x, q.y, sampler.next_1d()]
            });
            // Exceeded by one with probability 1e-7.
            assert!(found < 140.0, "{name}, sample {index}: {found}");
        }
    }
    // One shift for both pairs: each number alone is uniform.
    let shared = |seed: u64| {
        let mut sampler = Lattice::new(seed);
        let p = sampler.next_2d();
        [sampler.next_1d(), p.x, p.y, (p.x + 0.3).fract(), (p.y + 0.7).fract(), sampler.next_1d()]
    };
    assert!(chi2(&shared) > 140.0);
}

/// How often, over the seeds, the digit number `below` of the difference of two scrambled fractions is set, which agree in
/// `shared` digits: 1/2, if it is random for each subtree; in units of its standard error.
fn digit_of_difference(scramble: &dyn Fn(u32, u32) -> u32, shared: u32, below: u32) -> f64 {
    const SEEDS: u32 = 4096;
    let a = 0x5a5a_5a5a_u32;
    let b = a ^ (1 << (31 - shared));
    let set = (0..SEEDS).filter(|&s| {
        let seed = mix(u64::from(s), 77) as u32;
        (scramble(a, seed) ^ scramble(b, seed)) >> (31 - below) & 1 == 1
    });
    (set.count() as f64 - f64::from(SEEDS) / 2.0) / (f64::from(SEEDS) / 4.0).sqrt()
}

#[test]
fn scrambling_is_owens() {
    // 31 · 32 / 2 pairs of digits: beyond 5.5 standard errors, one in all with probability 2e-5.
    let is_owens = |scramble: &dyn Fn(u32, u32) -> u32| {
        (0..31_u32).all(|shared| {
            let above = (0..=shared).all(|digit| {
                // Shared digits stay shared, and the first that differs differs still.
                let z = digit_of_difference(scramble, shared, digit);
                let sure = 64.0;
                if digit < shared { (z + sure).abs() < 1e-9 } else { (z - sure).abs() < 1e-9 }
            });
            above && (shared + 1..32).all(|digit| digit_of_difference(scramble, shared, digit).abs() < 5.5)
        })
    };
    assert!(is_owens(&|fraction, seed| carried(fraction.reverse_bits(), seed).reverse_bits()));
    // A digital shift moves all subtrees alike, and a hash keeps no interval together.
    assert!(!is_owens(&|fraction, seed| fraction ^ seed));
    assert!(!is_owens(&|fraction, seed| mix(u64::from(fraction), u64::from(seed)) as u32));
}
