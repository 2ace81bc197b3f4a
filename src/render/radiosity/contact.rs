//! Where surfaces touch: the parts of a face that nothing can light, because something stands on them.
//!
//! Two ways of standing are seen. A face that lies in the plane of another and faces it covers it, and is covered by it. And
//! the lower edges of a shape without a bottom cover what lies within them, if they make a convex loop from the inside of
//! which only the backs of surfaces can be seen. Whatever else stands on a face is left to visibility.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::RadiosityError;
use super::face::{Face, Outline};
use super::polygon::Polygon;
use crate::math::frame::Frame;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::{Ray, Scene};

/// Distances below this share of the largest coordinate are none: what files of six or seven digits leave.
const TOUCHING: f64 = 1e-6;
/// Areas below this share of the smaller of two faces are no overlap.
const OVERLAP: f64 = 1e-6;
/// Directions tried from each of a few points inside a loop.
const LOOKS: u32 = 16;

/// For each face the convex parts of its plane that are covered.
///
/// Refuses faces that coincide and face the same way: a ray can meet only one of them, and nothing says which.
pub(super) fn covered(scene: &Scene, faces: &[Face]) -> Result<Vec<Vec<Polygon>>, RadiosityError> {
    let near = TOUCHING * scene.extent();
    let flat: Vec<(usize, &Polygon)> =
        faces.iter().enumerate().filter_map(|(i, face)| Some((i, flat(face)?))).collect();
    let mut covered = vec![Vec::new(); faces.len()];
    // Planes that coincide have the same distance from the origin, whichever way they face.
    let height = |polygon: &Polygon| polygon.normal().dot(polygon.centroid()).abs();
    let mut by_height = flat.clone();
    by_height.sort_by(|(_, a), (_, b)| height(a).total_cmp(&height(b)));
    for (k, &(i, a)) in by_height.iter().enumerate() {
        for &(j, b) in by_height[k + 1..].iter().take_while(|(_, b)| height(b) - height(a) <= near) {
            // Of two surfaces with the same look on both sides, the outsides touch: that of a block and that of what it stands on.
            if !(faces[i].outside && faces[j].outside && in_one_plane(a, b, near)) {
                continue;
            }
            let Some(common) = intersection(a, b).filter(|c| c.area() > OVERLAP * a.area().min(b.area())) else {
                continue;
            };
            if a.normal().dot(b.normal()) > 0.0 {
                let name = |face: usize| scene.shapes()[faces[face].shape].name.clone();
                return Err(RadiosityError::Coincident { first: name(i), second: name(j) });
            }
            covered[i].push(common.clone());
            covered[j].push(common);
        }
    }
    // What stands on a surface stands on its outside; the inside of a block is sealed anyway.
    for (i, polygon) in flat.into_iter().filter(|(i, _)| faces[*i].outside) {
        for shape in 0..scene.shapes().len() {
            for outline in loops_on(scene, shape, polygon, near) {
                if covered[i].iter().all(|seen| !overlap(seen, &outline))
                    && is_sealed(scene, &outline, polygon.normal())
                {
                    covered[i].push(outline);
                }
            }
        }
    }
    Ok(covered)
}

fn flat(face: &Face) -> Option<&Polygon> {
    match &face.outline {
        Outline::Flat(polygon) => Some(polygon),
        Outline::Curved(_) => None,
    }
}

fn in_one_plane(a: &Polygon, b: &Polygon, near: f64) -> bool {
    a.normal().dot(b.normal()).abs() > 1.0 - 1e-9
        && b.corners().iter().all(|&corner| a.distance_above(corner).abs() <= near)
}

/// What two polygons in one plane have in common.
fn intersection(a: &Polygon, b: &Polygon) -> Option<Polygon> {
    b.edges().try_fold(a.clone(), |rest, (from, to)| rest.above(from, b.normal().cross(to - from).normalize()))
}

fn overlap(a: &Polygon, b: &Polygon) -> bool {
    intersection(a, b).is_some_and(|common| common.area() > OVERLAP * a.area().min(b.area()))
}

/// `polygon` without `hole`, in convex pieces.
pub(super) fn without(polygon: &Polygon, hole: &Polygon) -> Vec<Polygon> {
    if !overlap(polygon, hole) {
        return vec![polygon.clone()];
    }
    let mut pieces = Vec::new();
    let mut rest = polygon.clone();
    for (from, to) in hole.edges() {
        let inwards = hole.normal().cross(to - from).normalize();
        pieces.extend(rest.above(from, -inwards));
        match rest.above(from, inwards) {
            Some(inside) => rest = inside,
            None => break,
        }
    }
    pieces.retain(|piece| piece.area() > OVERLAP * polygon.area());
    pieces
}

/// Convex loops of the lower edges of a shape that stands on the front of `ground`.
fn loops_on(scene: &Scene, shape: usize, ground: &Polygon, near: f64) -> Vec<Polygon> {
    let mut edges: Vec<(DVec3, DVec3)> = Vec::new();
    for triangle in 0..scene.triangles() {
        let (corners, of) = scene.triangle(triangle);
        if of != shape {
            continue;
        }
        let heights = corners.map(|corner| ground.distance_above(corner));
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            if heights[i].abs() <= near && heights[j].abs() <= near && heights[k] > near {
                edges.push((corners[i], corners[j]));
            }
        }
    }
    chained(&edges, near).into_iter().filter_map(|corners| Polygon::new(corners).ok()).collect()
}

/// Closed chains of edges whose ends meet, each corner being the end of one edge and the start of one.
fn chained(edges: &[(DVec3, DVec3)], near: f64) -> Vec<Vec<DVec3>> {
    let key = |p: DVec3| (p / (16.0 * near)).round().as_i64vec3().to_array();
    let mut next: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, (from, _)) in edges.iter().enumerate() {
        next.entry(key(*from)).or_default().push(i);
    }
    let mut used = vec![false; edges.len()];
    let mut loops = Vec::new();
    for first in 0..edges.len() {
        let mut corners = Vec::new();
        let mut at = first;
        while !used[at] {
            used[at] = true;
            corners.push(edges[at].0);
            match next.get(&key(edges[at].1)).map(Vec::as_slice) {
                Some(&[following]) => at = following,
                _ => break,
            }
        }
        if at == first && corners.len() >= 3 {
            loops.push(corners);
        }
    }
    loops
}

/// Whether from inside the loop, on the side of `normal`, nothing but backs of surfaces is seen.
fn is_sealed(scene: &Scene, outline: &Polygon, normal: DVec3) -> bool {
    let centre = outline.centroid();
    let frame = Frame::about(normal);
    let lift = normal * (outline.radius() * 1e-4);
    let points = outline.corners().iter().map(|&corner| centre + (corner - centre) * 0.9).chain([centre]);
    points.flat_map(|p| (0..LOOKS).map(move |i| (p, i))).all(|(p, i)| {
        let u = DVec2::new((f64::from(i) + 0.5) / f64::from(LOOKS), f64::from(i) * 0.618_033_988_749_895 % 1.0);
        let ray = Ray::new(p + lift, frame.to_world(cosine_hemisphere(u)));
        scene.intersect(&ray).is_some_and(|surface| surface.ng.dot(ray.dir) > 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::super::face::faces;
    use super::*;
    use crate::math::color::Rgb;
    use crate::scene::builtin::builtin;
    use crate::scene::{Geometry, Material, SceneDescription, Shape};

    fn covered_area(scene: &Scene, name: &str) -> f64 {
        let all = faces(scene).unwrap();
        let holes = covered(scene, &all).unwrap();
        let of_name = all.iter().zip(&holes).filter(|(face, _)| scene.shapes()[face.shape].name == name);
        of_name.flat_map(|(_, holes)| holes).map(Polygon::area).sum()
    }

    fn described(name: &str) -> SceneDescription {
        builtin(name, &[]).unwrap().unwrap()
    }

    #[test]
    fn the_blocks_of_the_cornell_box_stand_on_its_floor() {
        let scene = Scene::new(described("cornell-original")).unwrap();
        // Twice the area of a quadrangle is the cross product of its diagonals: published corners (x, z).
        let quadrangle =
            |[a, b, c, d]: [(f64, f64); 4]| 0.5 * ((c.0 - a.0) * (d.1 - b.1) - (c.1 - a.1) * (d.0 - b.0)).abs();
        let short = quadrangle([(130.0, 65.0), (82.0, 225.0), (240.0, 272.0), (290.0, 114.0)]);
        let tall = quadrangle([(423.0, 247.0), (265.0, 296.0), (314.0, 456.0), (472.0, 406.0)]);
        assert!((covered_area(&scene, "floor") - short - tall).abs() < 1e-9 * (short + tall));
        for name in ["back", "ceiling", "short-block", "tall-block"] {
            assert_eq!(covered_area(&scene, name), 0.0, "{name}");
        }
    }

    #[test]
    fn a_block_with_a_bottom_covers_the_floor_and_is_covered() {
        let scene = Scene::new(described("cornell-bitterli")).unwrap();
        let bottom = |x: [f64; 2], y: [f64; 2]| 4.0 * (x[0] * y[1] - x[1] * y[0]).abs();
        let short = bottom([0.0851643, -0.284951], [0.289542, 0.0865363]);
        let tall = bottom([0.286776, -0.0997984], [0.098229, 0.282266]);
        assert!((covered_area(&scene, "floor") - short - tall).abs() < 1e-9);
        assert!((covered_area(&scene, "short-block") - short).abs() < 1e-9);
    }

    #[test]
    fn surfaces_that_coincide_are_refused_by_name() {
        let mut description = described("cube-one-emitter");
        let mut twin = description.shapes[1].clone();
        twin.name = "twin".into();
        description.shapes.push(twin);
        let scene = Scene::new(description).unwrap();
        let error = covered(&scene, &faces(&scene).unwrap()).unwrap_err();
        let RadiosityError::Coincident { first, second } = error else { panic!("{error}") };
        assert_eq!([first, second], ["top", "twin"]);
    }

    #[test]
    fn a_room_does_not_cover_its_own_floor() {
        for name in ["cube-one-emitter", "furnace-box"] {
            let scene = Scene::new(described(name)).unwrap();
            assert!(covered(&scene, &faces(&scene).unwrap()).unwrap().iter().all(Vec::is_empty), "{name}");
        }
    }

    #[test]
    fn an_open_frame_covers_nothing() {
        // Four walls with no lid: one can look in from above.
        let mut description = described("cornell-original");
        let block = description.shapes.iter_mut().find(|shape| shape.name == "short-block").unwrap();
        let Geometry::Mesh(mesh) = &block.geometry else { panic!("no mesh") };
        let sides = mesh.triangles()[2..].to_vec();
        let open = crate::scene::Mesh::new(mesh.positions().to_vec(), sides).unwrap();
        *block = Shape { geometry: Geometry::Mesh(open.into()), ..block.clone() };
        let whole = covered_area(&Scene::new(described("cornell-original")).unwrap(), "floor");
        description.materials.push(Material::diffuse("unused", Rgb::BLACK.into()));
        let scene = Scene::new(description).unwrap();
        assert!(covered_area(&scene, "floor") < 0.6 * whole);
    }

    #[test]
    fn a_hole_takes_away_its_area() {
        let square = |x: f64, y: f64, side: f64| {
            let corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)];
            Polygon::new(corners.map(|(a, b)| DVec3::new(x + a, y + b, 0.0)).to_vec()).unwrap()
        };
        let area = |hole: &Polygon| without(&square(0.0, 0.0, 1.0), hole).iter().map(Polygon::area).sum::<f64>();
        assert!((area(&square(0.25, 0.5, 0.25)) - 15.0 / 16.0).abs() < 1e-15);
        assert!((area(&square(0.5, 0.5, 2.0)) - 0.75).abs() < 1e-15);
        assert!((area(&square(0.25, 0.5, 0.25).flipped()) - 15.0 / 16.0).abs() < 1e-15);
        assert_eq!(area(&square(-1.0, -1.0, 3.0)), 0.0);
        assert_eq!(without(&square(0.0, 0.0, 1.0), &square(1.0, 0.0, 1.0)).len(), 1);
    }
}
