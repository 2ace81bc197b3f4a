//! Conjugate gradients of the symmetrised system.
//!
//! By reciprocity A_i F_ij is symmetric, so that A_i/ρ_i times row i of I − ρF is a symmetric, positive definite system in B
//! on the patches with ρ > 0; the others have B = E. Preconditioned by its diagonal A_i/ρ_i, and from B = E, it is in terms of
//! the irradiance, B = E + ρ H,
//!
//! (I − Fρ) H = F E   with the inner product ⟨x, y⟩ = Σ_i A_i ρ_i x_i y_i
//!
//! step by step the same, but nothing is divided by ρ: a patch with ρ = 0 has no weight, and a tiny ρ is no trouble. The residual
//! of B is ρ times that of H. The eigenvalues lie in \[1 − max ρ, 1 + max ρ\].
//!
//! Without reciprocity the steps are not conjugate, and convergence is not certain; whatever comes out is certified as that of
//! every other solver.
//! # References
//! - Hestenes & Stiefel 1952, Methods of conjugate gradients for solving linear systems, J. Res. NBS 49(6)

use super::super::system::{System, largest};
use super::progress::{Claim, Progress};
use super::{Settings, Solved};
use crate::math::color::Rgb;

pub(super) fn solve(system: &System, settings: Settings) -> Solved {
    let mut progress = Progress::new(system, settings);
    let (rho, e) = (system.reflectance(), system.emission());
    let scale = largest(e.iter().copied());
    let weights: Vec<Rgb> = system.areas().iter().zip(rho).map(|(&area, &rho)| area * rho).collect();
    let mut h = vec![Rgb::BLACK; e.len()];
    let mut b = e.to_vec();
    let mut z = system.irradiance(e);
    let mut p = z.clone();
    let mut square = inner(&weights, &z, &z);
    let mut change = f64::INFINITY;
    loop {
        let residual = largest(rho.iter().zip(&z).map(|(&rho, &z)| rho * z));
        if progress.iterations > 0 {
            progress.history.push(residual);
        }
        let claim = Claim { residual, change, scale, largest: largest(b.iter().copied()) };
        let claimed = progress.claims(claim);
        let settled = claimed && progress.confirms(&b);
        if settled || !progress.may_go_on(claim) {
            return progress.finish(b, settled);
        }
        if claimed {
            // Roundings have taken the residual of the recurrence away from the true one: begin again from here.
            z = system.irradiance(&b).iter().zip(&h).map(|(&fb, &h)| fb - h).collect();
            p.clone_from(&z);
            square = inner(&weights, &z, &z);
        }
        let sent: Vec<Rgb> = rho.iter().zip(&p).map(|(&rho, &p)| rho * p).collect();
        let q: Vec<Rgb> = p.iter().zip(system.irradiance(&sent)).map(|(&p, fp)| p - fp).collect();
        let step = ratio(square, inner(&weights, &p, &q));
        change = largest(sent.iter().map(|&sent| step * sent));
        for i in 0..b.len() {
            h[i] += step * p[i];
            b[i] = e[i] + rho[i] * h[i];
            z[i] = z[i] - step * q[i];
        }
        let next = inner(&weights, &z, &z);
        let turn = ratio(next, square);
        square = next;
        for (p, &z) in p.iter_mut().zip(&z) {
            *p = z + turn * *p;
        }
        progress.iterations += 1;
    }
}

/// Σ_i w_i x_i y_i of each channel, in the order of i.
fn inner(weights: &[Rgb], x: &[Rgb], y: &[Rgb]) -> Rgb {
    weights.iter().zip(x).zip(y).map(|((&w, &x), &y)| w * x * y).sum()
}

/// a / b of each channel; 0 where b is not above 0, which is where a channel has nothing left to find.
fn ratio(a: Rgb, b: Rgb) -> Rgb {
    let of = |c: usize| if b.0[c] > 0.0 { a.0[c] / b.0[c] } else { 0.0 };
    Rgb::new(of(0), of(1), of(2))
}

#[cfg(test)]
mod tests {
    use super::super::networks::{colourful, cube};
    use super::super::{Method, Settings};

    #[test]
    fn a_cube_takes_as_many_steps_as_it_has_eigenvalues() {
        // Three distinct ones of six faces: the constant, the differences of opposite faces, the rest.
        for rho in [0.5, 0.9] {
            let system = cube(rho, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let found = Method::ConjugateGradient.solve(&system, Settings::default()).unwrap();
            assert!(found.converged && found.iterations <= 3, "{found:?}");
        }
    }

    #[test]
    fn it_needs_far_fewer_iterations_than_jacobi() {
        let system = cube(0.99, [1.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
        let count = |method: Method| method.solve(&system, Settings::default()).unwrap().iterations;
        assert!(20 * count(Method::ConjugateGradient) < count(Method::Jacobi));
        let system = colourful(200);
        let count = |method: Method| method.solve(&system, Settings::default()).unwrap().iterations;
        assert!(count(Method::ConjugateGradient) < count(Method::GaussSeidel));
    }
}
