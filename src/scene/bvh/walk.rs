//! The two ways through a tree: nearest first, and any.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::kernel::{Lanes, Stack, Waiting};
use super::node::{Beam, LEAF, Node};

/// Visits the leaves that the ray enters before `reach`, near ones first. A visit returns the reach from then on.
#[inline(always)]
pub(super) fn nearest_first<S: Lanes>(
    s: S,
    nodes: &[Node],
    root: u32,
    beam: &Beam<S>,
    mut reach: f32,
    mut visit: impl FnMut(u32) -> f32,
) {
    let mut stack = Stack::new();
    let mut at = root;
    let mut limit = s.splat(reach);
    loop {
        if at & LEAF == 0 {
            let node = &nodes[at as usize];
            let (enter, mut hit) = beam.enter(s, node, limit);
            if hit != 0 {
                let first = hit.trailing_zeros() as usize;
                hit &= hit - 1;
                if hit == 0 {
                    at = node.child[first & 7];
                    continue;
                }
                let mut t = [0.0; 8];
                s.store(enter, &mut t);
                let mut near = Waiting { t: t[first & 7], child: node.child[first & 7] };
                let mut count = 0;
                while hit != 0 {
                    let lane = hit.trailing_zeros() as usize;
                    hit &= hit - 1;
                    let mut other = Waiting { t: t[lane & 7], child: node.child[lane & 7] };
                    if other.t < near.t {
                        std::mem::swap(&mut near, &mut other);
                    }
                    stack.push(other);
                    count += 1;
                }
                if count > 1 {
                    stack.sort_top(count);
                }
                at = near.child;
                continue;
            }
        } else {
            reach = visit(at ^ LEAF);
            limit = s.splat(reach);
        }
        at = loop {
            match stack.pop() {
                None => return,
                Some(next) if next.t <= reach => break next.child,
                Some(_) => {}
            }
        };
    }
}

/// Visits the leaves that the ray enters before `reach` until a visit returns true; whether one did.
#[inline(always)]
pub(super) fn any<S: Lanes>(
    s: S,
    nodes: &[Node],
    root: u32,
    beam: &Beam<S>,
    reach: f32,
    mut visit: impl FnMut(u32) -> bool,
) -> bool {
    let mut stack = Stack::new();
    let mut at = root;
    let reach = s.splat(reach);
    loop {
        if at & LEAF == 0 {
            let node = &nodes[at as usize];
            let (_, mut hit) = beam.enter(s, node, reach);
            while hit != 0 {
                let lane = hit.trailing_zeros() as usize;
                hit &= hit - 1;
                stack.push(Waiting { t: 0.0, child: node.child[lane & 7] });
            }
        } else if visit(at ^ LEAF) {
            return true;
        }
        match stack.pop() {
            None => return false,
            Some(next) => at = next.child,
        }
    }
}
