//! Hierarchical radiosity: light between elements as large as the accuracy allows.
//!
//! A matrix of view factors has n² entries for n elements. But a wall that lights the opposite one does so almost as a whole:
//! only what is near, bright or half hidden needs small elements. Each face is a tree of ever smaller elements, and
//! light runs along links between any two of its levels.
//!
//! 1. Link all faces that see each other, and solve. Where there are many, they are put into clusters, and the cluster of all
//!    of them is linked with itself.
//! 2. Replace each link that leaves too large an error in what it brings by links to the parts of its receiver or source.
//! 3. Solve: gather along the links, push down the trees, pull up again. Repeat, with a stricter bound, until the error
//!    estimated of all links is what was asked for.
//!
//! Links are one way: a lamp lights a wall by many, the wall the lamp by one. So reciprocity holds as far as the error allows,
//! and [`HierarchicalSolution::energy`] says how far.
//! # References
//! - Hanrahan, Salzman & Aupperle 1991, A rapid hierarchical radiosity algorithm, SIGGRAPH

#[cfg(test)]
mod checks;

mod cluster;
mod cut;
mod growth;
mod link;
mod model;
mod network;
mod oracle;
mod tree;

pub use growth::{Growth, Size};
pub use model::{Hierarchical, HierarchicalSolution, Statistics};
