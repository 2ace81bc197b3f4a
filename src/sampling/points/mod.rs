//! Points of low discrepancy: samplers whose samples of one pixel know of each other.
//!
//! | name | numbers of samples that it likes | error for smooth integrands, and at an edge |
//! |---|---|---|
//! | `independent` | any | N^(−1/2), N^(−1/2) |
//! | `jittered` | squares | N^(−1), N^(−3/4) |
//! | `multi-jittered` | squares | N^(−1), N^(−3/4) |
//! | `halton` | any; 2^i 3^k above all | N^(−1) to N^(−3/2), N^(−3/4) |
//! | `lattice` | powers of two | N^(−1), N^(−3/4) |
//! | `sobol` | powers of two | N^(−3/2), N^(−3/4) |
//! | `blue-sobol` | powers of two | as `sobol`, and neighbouring pixels cancel each other's errors |
//!
//! Rates are those of two dimensions. The numbers of one sample are independent and uniform over the seeds, so that any mean
//! of N is unbiased. All but `halton` are padded: every dimension or pair of dimensions is stratified in itself, whatever the
//! others; of `lattice`, three pairs after each other are so together, two by two.

mod halton;
mod hash;
mod jittered;
mod lattice;
mod sobol;

pub use halton::Halton;
pub use jittered::Jittered;
pub use lattice::Lattice;
pub use sobol::Sobol;

#[cfg(test)]
mod tests;
