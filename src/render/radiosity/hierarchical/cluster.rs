//! Clusters: boxes full of faces, so that not all faces need a link to all others.
//!
//! Faces are halved again and again at the median of that coordinate in which they differ most: of their centres, or of their
//! normals as long as these differ by more than a right angle, so that a cluster soon looks one way. It sends and receives as the even
//! mixture of its faces: that is rough, and a link of one is kept only where even all that it brings hardly matters.
//! # References
//! - Smits, Arvo & Greenberg 1994, A clustering algorithm for radiosity in complex environments, SIGGRAPH

use std::ops::Range;

use glam::DVec3;

use crate::render::radiosity::factors::End;

/// Faces of a cluster that has no clusters in it, at most.
const FACES: usize = 4;

/// Normals differ much if the square of their range is larger: that of two at a right angle to each other.
const TURNED: f64 = 2.0;

/// What a cluster consists of, by position: of clusters, or of faces in their new order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Parts {
    Clusters(Range<usize>),
    Faces(Range<usize>),
}

/// Groups things by their centres and normals. Returns the clusters, parts after what they are parts of, and a new order of the things, in
/// which those of a cluster follow each other.
pub(super) fn group(things: &[End]) -> (Vec<Parts>, Vec<usize>) {
    let mut order: Vec<usize> = (0..things.len()).collect();
    let mut of: Vec<Range<usize>> = std::iter::once(0..things.len()).collect();
    let mut clusters = Vec::new();
    while clusters.len() < of.len() {
        let own = of[clusters.len()].clone();
        if own.len() <= FACES {
            clusters.push(Parts::Faces(own));
            continue;
        }
        let members = &mut order[own.clone()];
        let extent = |of: fn(&End) -> DVec3| {
            let first = of(&things[members[0]]);
            let range = |(low, high): (DVec3, DVec3), &i: &usize| (low.min(of(&things[i])), high.max(of(&things[i])));
            let (low, high) = members.iter().fold((first, first), range);
            high - low
        };
        let (size, turn) = (extent(|thing| thing.0), extent(|thing| thing.1));
        let of_normals = turn.length_squared() >= TURNED;
        let axis = if of_normals { turn.max_position() } else { size.max_position() };
        let key = |i: usize| if of_normals { things[i].1[axis] } else { things[i].0[axis] };
        let half = members.len() / 2;
        // By number where they are equal, so that the order is one and the same everywhere.
        members.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        clusters.push(Parts::Clusters(of.len()..of.len() + 2));
        of.extend([own.start..own.start + half, own.start + half..own.end]);
    }
    (clusters, order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::stream::{stream, uniform};

    fn members(clusters: &[Parts], at: usize) -> Vec<usize> {
        match &clusters[at] {
            Parts::Faces(own) => own.clone().collect(),
            Parts::Clusters(parts) => parts.clone().flat_map(|part| members(clusters, part)).collect(),
        }
    }

    #[test]
    fn every_face_is_in_one_cluster_and_neighbours_are_together() {
        let mut rng = stream(1, 0, 0);
        let mut place = || DVec3::from_array([(); 3].map(|()| uniform(&mut rng)));
        // Half of them look up, and half down.
        let things: Vec<End> = (0..1000).map(|i| (place(), if i % 2 == 0 { DVec3::Z } else { DVec3::NEG_Z })).collect();
        let (clusters, order) = group(&things);
        let mut all = order.clone();
        all.sort_unstable();
        assert_eq!(all, (0..1000).collect::<Vec<_>>());
        let mut held = members(&clusters, 0);
        held.sort_unstable();
        assert_eq!(held, (0..1000).collect::<Vec<_>>());
        for (at, cluster) in clusters.iter().enumerate() {
            match cluster {
                Parts::Clusters(parts) => assert!(parts.start > at && parts.end <= clusters.len() && parts.len() == 2),
                Parts::Faces(own) => {
                    assert!((1..=FACES).contains(&own.len()));
                    let (p, n) = things[order[own.start]];
                    for (q, m) in own.clone().map(|i| things[order[i]]) {
                        // A box of 1/128 of the volume has a side of .2.
                        assert!(m == n && p.distance(q) < 0.6);
                    }
                }
            }
        }
    }

    #[test]
    fn faces_at_one_place_are_grouped_too() {
        let (clusters, order) = group(&[(DVec3::ONE, DVec3::Z); 100]);
        assert_eq!(members(&clusters, 0).len(), 100);
        assert_eq!(order.len(), 100);
    }
}
