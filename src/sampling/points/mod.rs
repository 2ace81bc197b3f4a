//! Points of low discrepancy: samplers whose samples of one pixel know of each other.
//!
//! | name | numbers of samples that it likes | error for smooth integrands, and at an edge |
//! |---|---|---|
//! | `independent` | any | N^(−1/2), N^(−1/2) |
//! | `jittered` | squares | N^(−1), N^(−3/4) |
//! | `sobol` | powers of two | N^(−3/2), N^(−3/4) |
//!
//! Rates are those of two dimensions. Every value alone is uniform over the seeds, so that any mean of N is unbiased. One
//! number and one pair after the other, every dimension or pair of dimensions is stratified in itself, and independent of
//! the others ("padded").

mod hash;
mod jittered;
mod sobol;

pub use jittered::Jittered;
pub use sobol::Sobol;

#[cfg(test)]
mod tests;
