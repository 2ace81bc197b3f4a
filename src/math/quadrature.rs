//! One-dimensional quadrature: the Gauss-Kronrod 7-15 pair and its adaptive use.
//!
//! The error estimate of a panel is the plain difference of the two rules. That is the error of the *worse* rule, so
//! it bounds the error of the better one by a wide margin for every integrand smooth at the scale of the panel.
//!
//! # References
//! - Kronrod 1965; Piessens et al. 1983, QUADPACK (nodes and weights of the 7-15 pair)

/// Number of nodes of the Kronrod rule.
pub const NODES: usize = 15;

/// Positive Kronrod nodes in descending order, the centre last; every second one from index 1 is a Gauss node.
const HALF_NODES: [f64; 8] = [
    0.9914553711208126,
    0.9491079123427585,
    0.8648644233597691,
    0.7415311855993945,
    0.5860872354676911,
    0.4058451513773972,
    0.20778495500789848,
    0.0,
];
const HALF_KRONROD: [f64; 8] = [
    0.022935322010529224,
    0.06309209262997856,
    0.10479001032225019,
    0.14065325971552592,
    0.1690047266392679,
    0.19035057806478542,
    0.20443294007529889,
    0.20948214108472782,
];
const HALF_GAUSS: [f64; 4] = [0.1294849661688697, 0.27970539148927664, 0.3818300505051189, 0.4179591836734694];

/// One node of the pair on [0, 1]: position, Kronrod weight, Gauss weight (0 where the node is Kronrod's alone).
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Position in (0, 1).
    pub x: f64,
    /// Weight in the 15-point rule.
    pub kronrod: f64,
    /// Weight in the 7-point rule.
    pub gauss: f64,
}

/// The Gauss-Kronrod 7-15 pair on [0, 1], in ascending order.
pub const PAIR: [Node; NODES] = {
    let mut pair = [Node { x: 0.5, kronrod: 0.0, gauss: 0.0 }; NODES];
    let mut i = 0;
    while i < 8 {
        let gauss = if i % 2 == 1 { 0.5 * HALF_GAUSS[i / 2] } else { 0.0 };
        let kronrod = 0.5 * HALF_KRONROD[i];
        pair[i] = Node { x: 0.5 - 0.5 * HALF_NODES[i], kronrod, gauss };
        pair[NODES - 1 - i] = Node { x: 0.5 + 0.5 * HALF_NODES[i], kronrod, gauss };
        i += 1;
    }
    pair
};

/// The value of an integral of N functions at once, with a bound on the error of each.
#[derive(Clone, Copy, Debug)]
#[must_use]
pub struct Quadrature<const N: usize> {
    /// The integrals.
    pub value: [f64; N],
    /// A bound on the error of every one of them: the sum of the panels' estimates.
    pub error: f64,
    /// How many panels were used.
    pub panels: usize,
}

struct Panel<const N: usize> {
    from: f64,
    to: f64,
    value: [f64; N],
    error: f64,
}

fn panel<const N: usize>(f: &mut impl FnMut(f64) -> [f64; N], from: f64, to: f64) -> Panel<N> {
    let (mut kronrod, mut gauss) = ([0.0; N], [0.0; N]);
    for node in PAIR {
        let y = f(from + (to - from) * node.x);
        for c in 0..N {
            kronrod[c] += node.kronrod * y[c];
            gauss[c] += node.gauss * y[c];
        }
    }
    let width = to - from;
    let differences = kronrod.iter().zip(gauss).map(|(k, g)| (k - g).abs() * width);
    // A fold that keeps NaN, which f64::max would drop.
    let error = differences.fold(0.0, |worst: f64, d| if d <= worst { worst } else { d });
    Panel { from, to, value: kronrod.map(|k| k * width), error }
}

/// ∫ f over the range between the first and the last of `breaks` (ascending), split first at each of them.
///
/// Halves the worst panel until the summed estimate is at most `tol`, or `max_panels` are in use: compare
/// [`Quadrature::error`] with `tol` to tell. A NaN of `f` gives a NaN error, which compares as not resolved.
pub fn adaptive<const N: usize>(
    mut f: impl FnMut(f64) -> [f64; N],
    breaks: &[f64],
    tol: f64,
    max_panels: usize,
) -> Quadrature<N> {
    let mut panels: Vec<Panel<N>> = breaks.windows(2).map(|w| panel(&mut f, w[0], w[1])).collect();
    loop {
        let error: f64 = panels.iter().map(|p| p.error).sum();
        let worst = (0..panels.len()).max_by(|&a, &b| panels[a].error.total_cmp(&panels[b].error));
        let exhausted = panels.len() >= max_panels || error.is_nan();
        match worst {
            Some(worst) if error > tol && !exhausted => {
                let Panel { from, to, .. } = panels[worst];
                let middle = 0.5 * (from + to);
                panels[worst] = panel(&mut f, from, middle);
                panels.push(panel(&mut f, middle, to));
            }
            _ => {
                let mut value = [0.0; N];
                for p in &panels {
                    for (sum, v) in value.iter_mut().zip(p.value) {
                        *sum += v;
                    }
                }
                return Quadrature { value, error, panels: panels.len() };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_pair_is_exact_for_its_degrees() {
        // Kronrod 7-15 integrates degree 22 exactly, Gauss 7 degree 13; ∫₀¹ x^d dx = 1/(d + 1).
        for degree in 0..=22 {
            let exact = 1.0 / f64::from(degree + 1);
            let sum = |weight: fn(&Node) -> f64| PAIR.iter().map(|n| weight(n) * n.x.powi(degree)).sum::<f64>();
            assert_relative_eq!(sum(|n| n.kronrod), exact, max_relative = 1e-14);
            if degree <= 13 {
                assert_relative_eq!(sum(|n| n.gauss), exact, max_relative = 1e-14);
            }
        }
    }

    #[test]
    fn the_error_bound_holds_on_a_kink_and_on_an_end_singularity() {
        let kink = adaptive(|x| [(x - 0.3).abs()], &[0.0, 1.0], 1e-10, 200);
        assert!((kink.value[0] - (0.045 + 0.245)).abs() <= kink.error.max(1e-15) && kink.error <= 1e-10);
        let root = adaptive(|x: f64| [x.sqrt()], &[0.0, 1.0], 1e-9, 200);
        assert!((root.value[0] - 2.0 / 3.0).abs() <= root.error && root.error <= 1e-9);
    }

    #[test]
    fn what_cannot_be_resolved_says_so() {
        assert!(adaptive(|x: f64| [1.0 / x], &[0.0, 1.0], 1e-9, 50).error > 1e-9);
        assert!(adaptive(|_| [f64::NAN], &[0.0, 1.0], 1e-9, 50).error.is_nan());
    }
}
