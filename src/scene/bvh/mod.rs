//! What a ray meets first, among millions of triangles or a handful of spheres.
//!
//! Trees are eight wide, and boxes and triangles are tested eight at a time in f32 (by AVX-512, by AVX2, or by what the
//! compiler makes of plain arrays). That test errs only on one side: everything that an f64 test would hit passes it. What
//! passes is tested in f64, and that counts. Rays that go nearly the same way may go through a tree together.

mod aabb;
mod boxes;
mod build;
mod bundle;
mod exact;
mod fan;
mod few;
mod kernel;
mod leaves;
mod nearest;
mod node;
mod probe;
mod query;
mod split;
mod triangles;
mod walk;
mod work;

#[cfg(test)]
mod against_brute_force;

pub use aabb::Aabb;
pub use boxes::BoxBvh;
pub use exact::TriangleHit;
pub(crate) use kernel::prefetch;
pub use triangles::TriangleBvh;
pub(crate) use work::Work;
