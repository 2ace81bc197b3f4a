//! Transforms: steps that apply one after the other.

use glam::{DAffine3, DMat3, DVec3};

use super::document::{Document, Node};
use super::props::{number, numbers};
use crate::scene::camera::look_at;
use crate::scene::file::error::{SceneError, listed, quoted};

const STEPS: [&str; 5] = ["translate", "rotate", "scale", "lookat", "matrix"];

/// The steps within a `<transform>`, the first innermost.
pub(super) fn composed(document: &Document, node: &Node) -> Result<DAffine3, SceneError> {
    let mut whole = DAffine3::IDENTITY;
    for &id in &node.children {
        whole = step(document, document.node(id))? * whole;
        if !whole.is_finite() {
            return Err(bad(document, node, "the product of its steps", "finite numbers"));
        }
    }
    Ok(whole)
}

fn step(document: &Document, node: &Node) -> Result<DAffine3, SceneError> {
    match node.tag.as_str() {
        "translate" => Ok(DAffine3::from_translation(vector(document, node, 0.0)?)),
        "scale" => Ok(DAffine3::from_scale(scale(document, node)?)),
        "rotate" => {
            let axis = vector(document, node, 0.0)?;
            let axis = axis.try_normalize().ok_or_else(|| bad(document, node, "its axis", "a vector that is not 0"))?;
            let angle = attribute(document, node, "angle")?;
            Ok(DAffine3::from_axis_angle(axis, angle.to_radians()))
        }
        "lookat" => {
            let point = |name| {
                let text = node.attribute(name).ok_or_else(|| bad(document, node, name, "three numbers"))?;
                triple(document, node, name, text)
            };
            let (origin, target) = (point("origin")?, point("target")?);
            if (target - origin).try_normalize().is_none() {
                return Err(bad(document, node, "target", "a point that is not the origin"));
            }
            let up = if node.attribute("up").is_some() { point("up")? } else { DVec3::Y };
            if up.cross(target - origin).try_normalize().is_none() {
                return Err(bad(document, node, "up", "a vector that is not parallel to the direction of view"));
            }
            Ok(look_at(origin, target, up))
        }
        "matrix" => matrix(document, node),
        _ => Err(SceneError::Unsupported {
            place: document.place(node),
            what: format!("{} in <transform>", node.shown()),
            known: listed(STEPS),
        }),
    }
}

/// A point or vector: `value="x, y, z"`, or the attributes x, y and z, which are `absent` where they are not given.
pub(super) fn vector(document: &Document, node: &Node, absent: f64) -> Result<DVec3, SceneError> {
    if let Some(text) = node.attribute("value") {
        return triple(document, node, "value", text);
    }
    if ["x", "y", "z"].iter().all(|axis| node.attribute(axis).is_none()) {
        return Err(bad(document, node, "value", "three numbers, or the attributes x, y and z"));
    }
    let axis = |name| match node.attribute(name) {
        Some(_) => attribute(document, node, name),
        None => Ok(absent),
    };
    Ok(DVec3::new(axis("x")?, axis("y")?, axis("z")?))
}

fn scale(document: &Document, node: &Node) -> Result<DVec3, SceneError> {
    if let Some(text) = node.attribute("value")
        && let Some(all) = number(text.trim())
    {
        return Ok(DVec3::splat(all));
    }
    vector(document, node, 1.0)
}

/// Rows of 4 × 4 numbers, or of 3 × 3.
fn matrix(document: &Document, node: &Node) -> Result<DAffine3, SceneError> {
    const ALLOWED: &str = "16 numbers, row by row, the last row 0 0 0 1, or 9 numbers";
    let text = node.attribute("value").ok_or_else(|| bad(document, node, "value", ALLOWED))?;
    let m = numbers(text).ok_or_else(|| bad(document, node, "value", ALLOWED))?;
    let width = match m.len() {
        9 => 3,
        16 if m[12..] == [0.0, 0.0, 0.0, 1.0] => 4,
        _ => return Err(bad(document, node, "value", ALLOWED)),
    };
    let column = |c: usize| DVec3::new(m[c], m[width + c], m[2 * width + c]);
    let translation = if width == 4 { column(3) } else { DVec3::ZERO };
    Ok(DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), translation))
}

fn attribute(document: &Document, node: &Node, name: &str) -> Result<f64, SceneError> {
    let text = node.attribute(name).unwrap_or_default();
    number(text.trim()).ok_or_else(|| bad(document, node, name, "a finite number"))
}

fn triple(document: &Document, node: &Node, name: &str, text: &str) -> Result<DVec3, SceneError> {
    match numbers(text).as_deref() {
        Some(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err(bad(document, node, name, "three finite numbers")),
    }
}

fn bad(document: &Document, node: &Node, what: &str, allowed: &str) -> SceneError {
    let given = node.attribute(what).map_or_else(|| node.shown(), quoted);
    let what = format!("{what} of {}", node.shown());
    SceneError::Value { place: document.place(node), what, given, allowed: allowed.into() }
}
