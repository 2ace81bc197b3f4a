//! The two ways through a tree: nearest first, and any.
#![allow(clippy::inline_always, reason = "inlined into the functions that have a level's instructions enabled")]

use super::kernel::{Lanes, Stack};
use super::node::{Beam, LEAF, Node};

/// A child and the distance at which the ray enters its box, so that the order of numbers is that of distances, which
/// are not negative.
#[inline(always)]
fn waiting(t: f32, child: u32) -> u64 {
    u64::from(t.to_bits()) << 32 | u64::from(child)
}

/// Takes the lowest bit off.
#[inline(always)]
fn next_lane(hit: &mut u32) -> usize {
    let lane = hit.trailing_zeros() as usize & 7;
    *hit &= *hit - 1;
    lane
}

/// What has leaves that can be asked for. Not a closure: called from several places, it would not be inlined.
pub(super) trait Prefetch {
    /// Asks for a leaf that will be visited soon.
    fn prefetch<S: Lanes>(&self, s: S, leaf: u32);
}

/// Asks for a child that will be visited soon.
#[inline(always)]
fn ask<S: Lanes>(s: S, nodes: &[Node], child: u32, leaves: &impl Prefetch) {
    if child & LEAF == 0 {
        s.prefetch(&nodes[child as usize]);
    } else {
        leaves.prefetch(s, child ^ LEAF);
    }
}

/// What is done at a leaf. Not a closure, for the same reason.
pub(super) trait Visit<S> {
    /// Visits the leaf and returns the reach from then on.
    fn visit(&mut self, s: S, leaf: u32) -> f32;
}

/// Visits the leaves that the ray enters before `reach`, near ones first.
#[inline(always)]
pub(super) fn nearest_first<S: Lanes>(
    s: S,
    nodes: &[Node],
    root: u32,
    beam: &Beam<S>,
    mut reach: f32,
    leaves: &impl Prefetch,
    visitor: &mut impl Visit<S>,
) {
    let mut stack = Stack::new();
    let mut at = root;
    let mut limit = s.splat(reach);
    loop {
        if at & LEAF == 0 {
            let node = &nodes[at as usize];
            let (enter, mut hit) = beam.enter(s, node, limit);
            if hit != 0 {
                let first = next_lane(&mut hit);
                if hit == 0 {
                    at = node.child[first];

                    ask(s, nodes, at, leaves);
                    continue;
                }
                let mut t = [0.0; 8];
                s.store(enter, &mut t);
                let take = |lane: usize| {
                    ask(s, nodes, node.child[lane], leaves);
                    waiting(t[lane], node.child[lane])
                };
                let (a, b) = (take(first), take(next_lane(&mut hit)));
                let (near, far) = (a.min(b), a.max(b));
                if hit == 0 {
                    stack.push(far);
                    at = near as u32;
                    continue;
                }
                let c = take(next_lane(&mut hit));
                let (near, c) = (near.min(c), near.max(c));
                stack.push(far.max(c));
                stack.push(far.min(c));
                if hit == 0 {
                    at = near as u32;
                    continue;
                }
                let mut count = 3;
                stack.push(near);
                while hit != 0 {
                    stack.push(take(next_lane(&mut hit)));
                    count += 1;
                }
                stack.sort_top(count);
            }
        } else {
            reach = visitor.visit(s, at ^ LEAF);
            limit = s.splat(reach);
        }
        at = loop {
            match stack.pop() {
                None => return,
                Some(next) if f32::from_bits((next >> 32) as u32) <= reach => break next as u32,
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
    leaves: &impl Prefetch,
    mut visit: impl FnMut(u32) -> bool,
) -> bool {
    let mut stack = Stack::new();
    let mut at = root;
    let reach = s.splat(reach);
    loop {
        if at & LEAF == 0 {
            let node = &nodes[at as usize];
            let (_, mut hit) = beam.enter(s, node, reach);
            if hit != 0 {
                at = node.child[next_lane(&mut hit)];
                ask(s, nodes, at, leaves);
                while hit != 0 {
                    let child = node.child[next_lane(&mut hit)];
                    ask(s, nodes, child, leaves);
                    stack.push(u64::from(child));
                }
                continue;
            }
        } else if visit(at ^ LEAF) {
            return true;
        }
        match stack.pop() {
            None => return false,
            Some(next) => at = next as u32,
        }
    }
}
