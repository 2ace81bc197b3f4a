//! Small systems that tests solve, and what all solvers must agree on.

use super::super::matrix::FactorMatrix;
use super::super::system::{System, largest_gap};
use super::{Method, Settings, SolveError, Solved, Stop};
use crate::math::color::Rgb;
use crate::sampling::stream::{stream, uniform};

/// Unit squares at distance 1, and at a right angle.
const PARALLEL: f64 = 0.199824895698387;
const PERPENDICULAR: f64 = 0.200043776075403;

/// A cube of six patches: bottom, top, four sides.
pub(super) fn cube(rho: f64, emission: [f64; 6]) -> System {
    let factor = |i: usize, j: usize| match (i, j) {
        _ if i == j => 0.0,
        _ if i / 2 == j / 2 => PARALLEL,
        _ => PERPENDICULAR,
    };
    let factors = FactorMatrix::new(6, (0..36).map(|k| factor(k / 6, k % 6)).collect()).unwrap();
    System::new(factors, vec![1.0; 6], vec![Rgb::grey(rho); 6], emission.map(Rgb::grey).to_vec()).unwrap()
}

/// One patch that sees nothing but itself.
pub(super) fn alone(rho: f64) -> System {
    let factors = FactorMatrix::new(1, vec![1.0]).unwrap();
    System::new(factors, vec![2.0], vec![Rgb::grey(rho)], vec![Rgb::grey(3.0)]).unwrap()
}

/// The inside of a sphere in n patches of different areas, F_ij = A_j / ΣA; colours differ from patch to patch.
pub(super) fn sphere(n: usize) -> System {
    let mut rng = stream(1, 0, 0);
    let areas: Vec<f64> = (0..n).map(|_| 0.1 + uniform(&mut rng)).collect();
    let total: f64 = areas.iter().sum();
    let factors = FactorMatrix::new(n, (0..n * n).map(|k| areas[k % n] / total).collect()).unwrap();
    let mut colour = |most: f64| most * Rgb::new(uniform(&mut rng), uniform(&mut rng), uniform(&mut rng));
    let rho = (0..n).map(|_| colour(0.95)).collect();
    let emission = (0..n).map(|_| colour(2.0)).collect();
    System::new(factors, areas, rho, emission).unwrap()
}

/// A reciprocal matrix without any geometry, open, with patches that see themselves, black ones and dark ones among them.
pub(super) fn colourful(n: usize) -> System {
    let mut rng = stream(2, 0, 0);
    let areas: Vec<f64> = (0..n).map(|_| 0.5 + 2.0 * uniform(&mut rng)).collect();
    let mut exchange = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let value = (uniform(&mut rng) - 0.3).max(0.0);
            (exchange[i * n + j], exchange[j * n + i]) = (value, value);
        }
    }
    let sums = (0..n).map(|i| exchange[i * n..(i + 1) * n].iter().sum::<f64>() / areas[i]);
    let most = sums.fold(0.0, f64::max);
    let factors = FactorMatrix::new(n, (0..n * n).map(|k| exchange[k] / areas[k / n] / most).collect()).unwrap();
    let mut colour = |most: f64| most * Rgb::new(uniform(&mut rng), uniform(&mut rng), uniform(&mut rng));
    let rho = (0..n).map(|i| match i % 5 {
        0 => Rgb::BLACK,
        1 => colour(1e-200),
        2 => Rgb::new(0.0, 0.97, 0.5),
        _ => colour(0.99),
    });
    let rho = rho.collect();
    let emission = (0..n).map(|i| if i % 3 == 0 { colour(2.0) } else { Rgb::BLACK }).collect();
    System::new(factors, areas, rho, emission).unwrap()
}

fn all() -> Vec<System> {
    let bottom = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    vec![cube(0.5, bottom), cube(0.9, bottom), alone(0.7), sphere(40), colourful(60), colourful(301)]
}

fn solve(method: Method, system: &System) -> Solved {
    let found = method.solve(system, Settings { tolerance: 1e-12, ..Settings::default() }).unwrap();
    assert!(found.converged, "{method}: {}", found.certified_bound);
    found
}

#[test]
fn all_solvers_agree() {
    for system in all() {
        let dense = solve(Method::Dense, &system);
        for method in Method::ALL {
            let found = solve(method, &system);
            let gap = largest_gap(&found.radiosity, &dense.radiosity);
            // Tolerances of 1e-12 of radiosities of 10 at most.
            assert!(gap <= 1e-9, "{method}, n = {}: {gap}", system.n());
            let energy = system.energy(&found.radiosity);
            let share = energy.imbalance().map(f64::abs).max_channel() / energy.emitted.max_channel();
            assert!(share <= 1e-9, "{method}: {share} of the power is lost");
        }
    }
}

#[test]
fn inside_a_sphere_all_patches_receive_the_same() {
    // H = mean(E) / (1 − mean(ρ)) in every channel; means over the area.
    let system = sphere(40);
    let mean = |values: &[Rgb]| {
        let total: f64 = system.areas().iter().sum();
        values.iter().zip(system.areas()).map(|(&v, &area)| area / total * v).sum::<Rgb>()
    };
    let h = mean(system.emission()) / (Rgb::WHITE - mean(system.reflectance()));
    let exact: Vec<Rgb> = system.emission().iter().zip(system.reflectance()).map(|(&e, &rho)| e + rho * h).collect();
    for method in Method::ALL {
        assert!(largest_gap(&solve(method, &system).radiosity, &exact) <= 1e-9, "{method}");
    }
}

#[test]
fn concentric_spheres() {
    // The inner one sees the outer; the outer sees itself too: F_22 = 1 − k².
    let (k2, rho): (f64, [f64; 2]) = (0.25, [0.3, 0.7]);
    let factors = FactorMatrix::new(2, vec![0.0, 1.0, k2, 1.0 - k2]).unwrap();
    let rho = rho.map(Rgb::grey).to_vec();
    let system = System::new(factors, vec![k2, 1.0], rho, vec![Rgb::WHITE, Rgb::BLACK]).unwrap();
    for method in Method::ALL {
        let found = solve(method, &system).radiosity;
        let gap = largest_gap(&found, &[Rgb::grey(1.12426035503), Rgb::grey(0.414201183432)]);
        assert!(gap <= 1e-11, "twelve digits are known: {method}, {gap}");
        let energy = system.energy(&found);
        assert!((energy.absorbed - energy.emitted).map(f64::abs).max_channel() <= 1e-11, "{energy:?}");
    }
}

/// `found` is no further from `exact` than `bound` says, up to the roundings of radiosities of 10 at most.
fn is_bound(bound: f64, found: &[Rgb], exact: &[Rgb]) -> bool {
    largest_gap(found, exact) <= bound + 1e-13
}

#[test]
fn the_certified_bound_bounds_the_error() {
    let mut below = false;
    for system in all() {
        let exact = solve(Method::Dense, &system).radiosity;
        for method in Method::ALL {
            for max_iterations in [0, 1, 3, 10, 30, 100] {
                let settings = Settings { max_iterations, tolerance: 1e-14, ..Settings::default() };
                let found = method.solve(&system, settings).unwrap();
                assert!(is_bound(found.certified_bound, &found.radiosity, &exact), "{method}, {max_iterations}");
                // A twin that leaves 1 / (1 − max ρ) out.
                below |= !is_bound(found.residual, &found.radiosity, &exact);
            }
        }
    }
    assert!(below, "a bound without 1 / (1 − max ρ) is not seen");
    // A twin that forgets what patches send to themselves, and certifies itself by its own system.
    let system = sphere(10);
    let n = system.n();
    let blind = (0..n * n).map(|k| if k / n == k % n { 0.0 } else { system.factors().at(k / n, k % n) }).collect();
    let blind = System::new(
        FactorMatrix::new(n, blind).unwrap(),
        system.areas().to_vec(),
        system.reflectance().to_vec(),
        system.emission().to_vec(),
    );
    let twin = solve(Method::Dense, &blind.unwrap());
    let exact = solve(Method::Dense, &system).radiosity;
    assert!(!is_bound(twin.certified_bound, &twin.radiosity, &exact), "the twin's bound is not refuted");
    assert!(is_bound(system.certified_bound(system.residual(&twin.radiosity)), &twin.radiosity, &exact));
}

#[test]
fn without_reciprocity_shots_still_find_the_solution() {
    // The factors of one half a thousandth too small.
    let system = colourful(60);
    let n = system.n();
    let value = |k: usize| system.factors().at(k / n, k % n) * if k % n > k / n { 0.999 } else { 1.0 };
    let system = System::new(
        FactorMatrix::new(n, (0..n * n).map(value).collect()).unwrap(),
        system.areas().to_vec(),
        system.reflectance().to_vec(),
        system.emission().to_vec(),
    )
    .unwrap();
    let exact = solve(Method::Dense, &system).radiosity;
    assert!(system.energy(&exact).reciprocity_defect.map(f64::abs).max_channel() > 1e-4);
    for method in Method::ALL {
        assert!(largest_gap(&solve(method, &system).radiosity, &exact) <= 1e-9, "{method}");
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let system = colourful(301);
    for method in Method::ALL {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| method.solve(&system, Settings::default()).unwrap())
        };
        let one = with(1);
        assert!(one == with(2) && one == with(3), "{method}");
    }
}

#[test]
fn darkness_is_solved_at_once() {
    for method in Method::ALL {
        for stop in [Stop::Certified, Stop::Change] {
            let found = method.solve(&cube(0.9, [0.0; 6]), Settings { stop, ..Settings::default() }).unwrap();
            assert!(found.converged && found.iterations <= 1 && found.radiosity.iter().all(|b| b.is_black()));
        }
    }
}

#[test]
fn to_give_up_is_said() {
    for method in [Method::Jacobi, Method::GaussSeidel, Method::ConjugateGradient, Method::Southwell] {
        for stop in [Stop::Certified, Stop::Change] {
            let settings = Settings { max_iterations: 2, stop, ..Settings::default() };
            let found = method.solve(&colourful(60), settings).unwrap();
            assert!(found.iterations == 2 && !found.converged, "{method}");
        }
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let system = alone(0.5);
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = Method::Jacobi.solve(&system, Settings { tolerance, ..Settings::default() });
        assert!(matches!(found, Err(SolveError::Tolerance(_))));
    }
    for method in Method::ALL {
        let found = method.solve(&system, Settings { bounces: Some(2), ..Settings::default() });
        assert_eq!(found.is_ok(), method == Method::Jacobi);
        assert_eq!(method.name().parse(), Ok(method));
    }
    assert!("lu".parse::<Method>().unwrap_err().to_string().contains("gauss-seidel"));
}
