//! Triangle meshes.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use thiserror::Error;

use crate::math::color::Rgb;

/// Triangles with shared vertices; normals, texture coordinates and colours are per vertex and optional.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    uvs: Vec<DVec2>,
    colors: Vec<Rgb>,
    triangles: Vec<[u32; 3]>,
}

/// Why a mesh cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// Its number, from 0.
        triangle: usize,
        /// The vertex it names, from 0.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A position, normal, texture coordinate or colour is NaN or infinite.
    #[error("the {attribute} of vertex {vertex} is not finite")]
    NotFinite {
        /// Which of the attributes.
        attribute: &'static str,
        /// The vertex, from 0.
        vertex: usize,
    },
    /// There must be one value per vertex, or none.
    #[error("{found} {attribute}s for {vertices} vertices; allowed is one each, or none at all")]
    Count {
        /// Which of the attributes.
        attribute: &'static str,
        /// How many there are.
        found: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More than 2³² − 1 vertices or triangles.
    #[error("{0} vertices or triangles; allowed are 4294967295")]
    TooLarge(usize),
}

impl Mesh {
    /// A mesh of `positions` and `triangles` of indices into them, counter-clockwise seen from outside.
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let vertices = positions.len();
        if vertices.max(triangles.len()) > u32::MAX as usize {
            return Err(MeshError::TooLarge(vertices.max(triangles.len())));
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&corner| corner as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle, vertex, vertices });
            }
        }
        all_finite("position", positions.iter().map(|p| p.is_finite()))?;
        Ok(Self { positions, triangles, ..Self::default() })
    }

    /// The same with a normal per vertex, of any length; where it is 0 the triangle's own counts.
    pub fn with_normals(mut self, normals: Vec<DVec3>) -> Result<Self, MeshError> {
        self.check("normal", normals.len(), normals.iter().map(|n| n.is_finite()))?;
        self.normals = normals.into_iter().map(DVec3::normalize_or_zero).collect();
        Ok(self)
    }

    /// The same with texture coordinates per vertex.
    pub fn with_uvs(mut self, uvs: Vec<DVec2>) -> Result<Self, MeshError> {
        self.check("texture coordinate", uvs.len(), uvs.iter().map(|uv| uv.is_finite()))?;
        self.uvs = uvs;
        Ok(self)
    }

    /// The same with a linear colour per vertex.
    pub fn with_colors(mut self, colors: Vec<Rgb>) -> Result<Self, MeshError> {
        self.check("colour", colors.len(), colors.iter().map(|c| c.is_finite()))?;
        self.colors = colors;
        Ok(self)
    }

    /// The same without normals, so that every triangle is flat.
    pub fn faceted(mut self) -> Self {
        self.normals = Vec::new();
        self
    }

    /// The same with normals at the vertices: those of the triangles around, weighted by their angles.
    ///
    /// Angles and not areas: how a flat part is cut into triangles then changes nothing (Thürmer & Wüthrich 1998,
    /// Journal of Graphics Tools 3(1)).
    pub fn smoothed(mut self) -> Self {
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for corners in &self.triangles {
            let p = corners.map(|corner| self.positions[corner as usize]);
            let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
            for at in 0..3 {
                let (a, b) = (p[(at + 1) % 3] - p[at], p[(at + 2) % 3] - p[at]);
                normals[corners[at] as usize] += normal * a.angle_between(b);
            }
        }
        self.normals = normals.into_iter().map(DVec3::normalize_or_zero).collect();
        self
    }

    /// The same with texture coordinates that run downwards: v becomes 1 − v.
    pub fn with_flipped_v(mut self) -> Self {
        for uv in &mut self.uvs {
            uv.y = 1.0 - uv.y;
        }
        self
    }

    /// The mesh moved by `to_world`. A map that mirrors turns the triangles around, so that outside stays outside.
    pub fn transformed(mut self, to_world: DAffine3) -> Result<Self, MeshError> {
        for p in &mut self.positions {
            *p = to_world.transform_point3(*p);
        }
        // Normals are covectors: the cofactor matrix keeps them perpendicular, and is defined for flat maps too.
        let m = to_world.matrix3;
        let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let mirrors = m.determinant() < 0.0;
        for n in &mut self.normals {
            let turned = (cofactors * *n).normalize_or_zero();
            *n = if mirrors { -turned } else { turned };
        }
        if mirrors {
            for corners in &mut self.triangles {
                corners.swap(1, 2);
            }
        }
        all_finite("position", self.positions.iter().map(|p| p.is_finite()))?;
        Ok(self)
    }

    /// Positions of the vertices.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Unit normals of the vertices, or none.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// Texture coordinates of the vertices, or none.
    pub fn uvs(&self) -> &[DVec2] {
        &self.uvs
    }

    /// Linear colours of the vertices, or none.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }

    /// The triangles, as indices of vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    fn check(
        &self,
        attribute: &'static str,
        found: usize,
        finite: impl Iterator<Item = bool>,
    ) -> Result<(), MeshError> {
        if found != self.positions.len() {
            return Err(MeshError::Count { attribute, found, vertices: self.positions.len() });
        }
        all_finite(attribute, finite)
    }
}

fn all_finite(attribute: &'static str, mut finite: impl Iterator<Item = bool>) -> Result<(), MeshError> {
    match finite.position(|good| !good) {
        Some(vertex) => Err(MeshError::NotFinite { attribute, vertex }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> Mesh {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        Mesh::new(positions, vec![[0, 1, 2]]).unwrap().with_normals(vec![DVec3::Z * 3.0; 3]).unwrap()
    }

    #[test]
    fn bad_meshes_are_refused() {
        let bad = Mesh::new(vec![DVec3::ZERO; 2], vec![[0, 1, 2]]);
        assert_eq!(bad.unwrap_err(), MeshError::IndexOutOfRange { triangle: 0, vertex: 2, vertices: 2 });
        let nan = Mesh::new(vec![DVec3::ZERO, DVec3::splat(f64::NAN)], vec![]);
        assert_eq!(nan.unwrap_err(), MeshError::NotFinite { attribute: "position", vertex: 1 });
        assert!(triangle().with_uvs(vec![DVec2::ZERO]).is_err());
    }

    #[test]
    fn smooth_normals_are_weighted_by_angles() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y * 3.0, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let smooth = Mesh::new(positions, triangles).unwrap().smoothed();
        // At the origin three right angles meet.
        assert!((smooth.normals()[0] + DVec3::ONE / 3.0_f64.sqrt()).length() < 1e-15);
        // Mitsuba 3.9.1 for the same mesh, in single precision.
        let theirs = DVec3::new(-0.10823227, 0.98821634, -0.10823227);
        assert!((smooth.normals()[2] - theirs).length() < 1e-7, "{}", smooth.normals()[2]);
    }

    #[test]
    fn normals_stay_perpendicular_and_outside() {
        for scale in [DVec3::new(1.0, 2.0, 5.0), DVec3::new(-1.0, 2.0, 5.0), DVec3::new(1.0, 1.0, -3.0)] {
            let shear = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.3, 0.2, 1.0));
            let map = DAffine3::from_mat3(DMat3::from_diagonal(scale) * shear);
            let mesh = triangle().transformed(map).unwrap();
            let [a, b, c] = mesh.triangles()[0].map(|i| mesh.positions()[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            assert!((mesh.normals()[0] - normal).length() < 1e-14, "{scale}: {} against {normal}", mesh.normals()[0]);
            // Above the triangle stays above.
            let above = map.transform_point3(DVec3::new(0.2, 0.2, 1.0));
            assert!((above - a).dot(normal) > 0.0, "{scale}");
        }
    }
}
