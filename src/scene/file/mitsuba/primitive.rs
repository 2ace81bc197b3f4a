//! Shapes that are no meshes, and the maps that leave them what they are.

use glam::{DAffine3, DMat3, DVec3};

use super::Context;
use super::props::Props;
use crate::scene::file::error::SceneError;
use crate::scene::shape::Geometry;

/// How well lengths and angles must agree: exporters write matrices with five digits.
const TOLERANCE: f64 = 1e-3;

/// The lengths of the images of the axes.
fn scales(to_world: &DAffine3) -> DVec3 {
    let m = to_world.matrix3;
    DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
}

fn agree(a: f64, b: f64) -> bool {
    (a - b).abs() <= TOLERANCE * a.abs().max(b.abs())
}

fn upright(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= TOLERANCE * a.length() * b.length()
}

pub(super) fn sphere(
    context: &Context<'_>,
    props: &Props<'_>,
    to_world: &DAffine3,
    textured: bool,
) -> Result<Geometry, SceneError> {
    let centre = props.vector("center")?.unwrap_or(DVec3::ZERO);
    let radius = props.positive("radius", 1.0)?;
    let (scales, m) = (scales(to_world), to_world.matrix3);
    let round = agree(scales.x, scales.y) && agree(scales.x, scales.z);
    if !(round && upright(m.x_axis, m.y_axis) && upright(m.x_axis, m.z_axis) && upright(m.y_axis, m.z_axis)) {
        let error = props.unsupported("to_world", "an ellipsoid", "the same scale along every axis");
        context.notes.unsupported(error, "the scale along x counts")?;
    }
    let radius = radius * scales.x;
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(props.bad("to_world", "a scale that leaves no radius", "a radius > 0"));
    }
    if textured && !(m * scales.x.recip()).abs_diff_eq(DMat3::IDENTITY, TOLERANCE) {
        let error = props.unsupported("to_world", "a turned sphere with a texture", "a sphere whose pole is +z");
        context.notes.unsupported(error, "the texture is not turned")?;
    }
    Ok(Geometry::Sphere { centre: to_world.transform_point3(centre), radius })
}

pub(super) fn cylinder(
    context: &Context<'_>,
    props: &Props<'_>,
    to_world: &DAffine3,
    textured: bool,
) -> Result<Geometry, SceneError> {
    let from = props.vector("p0")?.unwrap_or(DVec3::ZERO);
    let to = props.vector("p1")?.unwrap_or(DVec3::Z);
    let radius = props.positive("radius", 1.0)?;
    let Some(axis) = (to - from).try_normalize() else {
        return Err(props.bad("p1", "the same as p0", "another point"));
    };
    let (u, v) = axis.any_orthonormal_pair();
    let [u, v, w] = [u, v, axis].map(|direction| to_world.transform_vector3(direction));
    if !(agree(u.length(), v.length()) && upright(u, v) && upright(u, w) && upright(v, w)) {
        let error = props.unsupported("to_world", "a cylinder out of round", "the same scale across the axis");
        context.notes.unsupported(error, "it stays round")?;
    }
    let radius = radius * u.length();
    if !(radius > 0.0 && radius.is_finite() && w.length() > 0.0) {
        return Err(props.bad("to_world", "a scale that leaves nothing", "a radius > 0"));
    }
    // Where u is 0 is a rule of the axis alone, here as there, but there before it is moved.
    let (here, across) = w.normalize().any_orthonormal_pair();
    let moved = [(u, here), (v, across)].iter().all(|(there, here)| there.angle_between(*here) <= TOLERANCE);
    if textured && !moved {
        let error = props.unsupported("to_world", "a turned cylinder with a texture", "a cylinder that is not turned");
        context.notes.unsupported(error, "the texture is not turned")?;
    }
    Ok(Geometry::Cylinder { from: to_world.transform_point3(from), to: to_world.transform_point3(to), radius })
}

pub(super) fn disk(context: &Context<'_>, props: &Props<'_>, to_world: &DAffine3) -> Result<Geometry, SceneError> {
    let (scales, m) = (scales(to_world), to_world.matrix3);
    if !(agree(scales.x, scales.y) && upright(m.x_axis, m.y_axis)) {
        let error = props.unsupported("to_world", "an elliptic disk", "the same scale along x and y");
        context.notes.unsupported(error, "it is drawn as it comes")?;
    }
    Ok(Geometry::Disk { to_world: *to_world })
}
