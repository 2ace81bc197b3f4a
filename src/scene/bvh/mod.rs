//! stub
#![allow(missing_docs)]
use super::Ray;
use glam::DVec3;
#[derive(Clone, Copy, Debug)]
pub struct Aabb {
    pub min: DVec3,
    pub max: DVec3,
}
#[derive(Clone, Copy, Debug)]
pub struct TriangleHit {
    pub t: f64,
    pub triangle: u32,
    pub b1: f64,
    pub b2: f64,
}
#[derive(Debug)]
pub struct TriangleBvh {
    v: Vec<[DVec3; 3]>,
}
impl TriangleBvh {
    pub fn build(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        Self { v: triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect() }
    }
    pub fn closest(&self, ray: &Ray) -> Option<TriangleHit> {
        let mut best: Option<TriangleHit> = None;
        for (i, [a, b, c]) in self.v.iter().enumerate() {
            let (e1, e2) = (*b - *a, *c - *a);
            let p = ray.dir.cross(e2);
            let det = e1.dot(p);
            if det == 0.0 {
                continue;
            }
            let inv = 1.0 / det;
            let s = ray.origin - *a;
            let b1 = s.dot(p) * inv;
            if !(0.0..=1.0).contains(&b1) {
                continue;
            }
            let q = s.cross(e1);
            let b2 = ray.dir.dot(q) * inv;
            if b2 < 0.0 || b1 + b2 > 1.0 {
                continue;
            }
            let t = e2.dot(q) * inv;
            if t > 0.0 && t < best.map_or(ray.t_max, |b| b.t) {
                best = Some(TriangleHit { t, triangle: i as u32, b1, b2 });
            }
        }
        best
    }
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.closest(ray).is_some()
    }
    pub fn memory_bytes(&self) -> usize {
        0
    }
    pub fn bounds(&self) -> Aabb {
        let all = || self.v.iter().flatten();
        Aabb {
            min: all().fold(DVec3::INFINITY, |a, b| a.min(*b)),
            max: all().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b)),
        }
    }
}
#[derive(Debug)]
pub struct BoxBvh {
    n: u32,
}
impl BoxBvh {
    pub fn build(boxes: &[Aabb]) -> Self {
        Self { n: boxes.len() as u32 }
    }
    pub fn closest(&self, ray: &Ray, hit: &mut dyn FnMut(u32, f64) -> Option<f64>) -> Option<(u32, f64)> {
        let mut best = None;
        let mut t_max = ray.t_max;
        for i in 0..self.n {
            if let Some(t) = hit(i, t_max) {
                t_max = t;
                best = Some((i, t));
            }
        }
        best
    }
    pub fn bounds(&self) -> Aabb {
        Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }
}
pub fn offset_origin(p: DVec3, ng: DVec3, dir: DVec3) -> DVec3 {
    let e = p.abs().max_element().max(1e-3) * 1e-12;
    if dir.dot(ng) > 0.0 { p + ng * e } else { p - ng * e }
}
