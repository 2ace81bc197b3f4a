//! Scenes: rays and what they meet.

pub mod bvh;
pub mod ray;
