//! Cameras: from a point of the film to a ray.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec2, DVec3};

use super::Ray;
use crate::sampling::warp::concentric_disk;

/// A camera, placed by a map from its own space, in which it looks along +z with +y up and +x to the image's **left**
/// (right-handed, as in Mitsuba).
#[derive(Clone, Debug)]
pub struct Camera {
    /// From camera space to the world. Scale along x and y counts for orthographic cameras only.
    pub to_world: DAffine3,
    /// How film points become rays.
    pub projection: Projection,
}

/// How film points become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays leave from one point.
    Perspective {
        /// Tangent of half the horizontal angle of view.
        tan_half_x: f64,
    },
    /// Rays leave from a lens of this radius; what lies in the plane of focus is sharp.
    ThinLens {
        /// Tangent of half the horizontal angle of view.
        tan_half_x: f64,
        /// Radius of the lens, > 0.
        radius: f64,
        /// Distance of the plane of focus from the lens, along the axis.
        focus: f64,
    },
    /// All rays are parallel; the image is 2 units of camera space wide.
    Orthographic,
}

impl Camera {
    /// A perspective camera at `eye` that looks at `target`; `fov_x_deg` is the full horizontal angle.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3, fov_x_deg: f64) -> Self {
        let projection = Projection::Perspective { tan_half_x: (0.5 * fov_x_deg.to_radians()).tan() };
        Self { to_world: look_at(eye, target, up), projection }
    }

    /// The ray through `film`, in [0, 1]² with (0, 0) the upper left corner; `aspect` is width over height; `lens` in
    /// [0, 1)² picks the point of the lens.
    pub fn ray(&self, film: DVec2, aspect: f64, lens: DVec2) -> Ray {
        let (x, y) = (1.0 - 2.0 * film.x, (1.0 - 2.0 * film.y) / aspect);
        let (origin, dir) = match self.projection {
            Projection::Perspective { tan_half_x } => (DVec3::ZERO, DVec3::new(x * tan_half_x, y * tan_half_x, 1.0)),
            Projection::ThinLens { tan_half_x, radius, focus } => {
                let on_lens = concentric_disk(lens) * radius;
                let sharp = DVec3::new(x * tan_half_x, y * tan_half_x, 1.0) * focus;
                let origin = on_lens.extend(0.0);
                (origin, sharp - origin)
            }
            Projection::Orthographic => (DVec3::new(x, y, 0.0), DVec3::Z),
        };
        let dir = self.to_world.transform_vector3(dir).normalize();
        Ray::new(self.to_world.transform_point3(origin), dir)
    }

    /// Whether a point of the lens is needed.
    pub fn has_lens(&self) -> bool {
        matches!(self.projection, Projection::ThinLens { .. })
    }
}

/// The map of a camera at `eye` that looks at `target`: +z forwards, +y as near to `up` as can be, +x to the left.
///
/// Where `up` is parallel to the direction of view, or the two points coincide, any perpendicular will do.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> DAffine3 {
    let forward = (target - eye).normalize_or(DVec3::Z);
    let left = up.cross(forward).normalize_or(forward.any_orthonormal_vector());
    DAffine3::from_cols(left, forward.cross(left), forward, eye)
}

/// The full horizontal angle in radians whose vertical angle is `fov_y`, for an image of this aspect.
pub fn horizontal_fov(fov_y: f64, aspect: f64) -> f64 {
    debug_assert!(fov_y.abs() < TAU);
    2.0 * ((0.5 * fov_y).tan() * aspect).atan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_centre_looks_at_the_target_and_left_is_left() {
        // The original Cornell camera: x grows to the left of the image.
        let eye = DVec3::new(278.0, 273.0, -800.0);
        let camera = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, 39.3077);
        let centre = camera.ray(DVec2::splat(0.5), 1.0, DVec2::ZERO);
        assert_abs_diff_eq!(centre.dir, DVec3::Z, epsilon = 1e-15);
        let corner = camera.ray(DVec2::ZERO, 2.0, DVec2::ZERO).dir;
        assert!(corner.x > 0.0 && corner.y > 0.0);
        assert_abs_diff_eq!(corner.x / corner.z, (0.5 * 39.3077_f64.to_radians()).tan(), epsilon = 1e-15);
        assert_abs_diff_eq!(corner.y / corner.x, 0.5, epsilon = 1e-15);
    }

    #[test]
    fn rays_through_a_lens_meet_in_the_plane_of_focus() {
        let projection = Projection::ThinLens { tan_half_x: 0.7, radius: 0.2, focus: 3.0 };
        let camera = Camera { to_world: DAffine3::IDENTITY, projection };
        let film = DVec2::new(0.2, 0.9);
        let sharp = |lens| {
            let ray = camera.ray(film, 1.5, lens);
            ray.at((3.0 - ray.origin.z) / ray.dir.z)
        };
        assert_abs_diff_eq!(sharp(DVec2::new(0.1, 0.9)), sharp(DVec2::new(0.8, 0.3)), epsilon = 1e-14);
    }
}
