//! Scenes: shapes, materials, lights and a camera, and the rays that are cast among them.

pub mod camera;
pub mod description;
pub mod file;
pub mod light;
pub mod material;
pub mod mesh;
pub mod shape;
pub mod texture;

mod ray;

pub use camera::{Camera, Projection};
pub use description::{FilmSettings, FilterKind, RenderSettings, SceneDescription};
pub use light::{EnvironmentMap, Light};
pub use material::{LocalBsdf, Material, Varying};
pub use mesh::{Mesh, MeshError};
pub use ray::Ray;
pub use shape::{Geometry, Shape};
pub use texture::{Bitmap, Texture, Wrap};
