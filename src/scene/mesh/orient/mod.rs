//! Orientation: the faces of each connected part are made consistent, and point outwards.
//!
//! A closed part points away from the medium: outwards, or inwards if it is the wall of a cavity, which follows from
//! the number of other closed parts that contain it. An open part keeps the side on which most of its area already is.

use super::edges::{Edges, NONE, start};
use super::{Mesh, nesting};
use crate::scene::range::Checked;
use glam::DVec3;

/// A connected part: faces joined by edges that exactly two faces share.
#[derive(Debug)]
struct Part {
    faces: Vec<u32>,
    /// Every edge has two faces with consistent orientation.
    closed: bool,
}

/// Flips faces where needed, counts open edges, and reports repairs and warnings. Returns an error if the nesting of
/// parts would take too long to decide.
pub(super) fn orient(mesh: &mut Mesh, report: &mut Vec<String>) -> Checked<()> {
    let edges = Edges::of(&mesh.triangles);
    mesh.open_edges = edges.open;
    let mut reversed = vec![false; mesh.triangles.len()];
    let (mut parts, part_of) = split(&mesh.triangles, &edges, &mut reversed);
    let disagreeing = disagreements(&mesh.triangles, &edges, &reversed);
    for half in &disagreeing {
        parts[part_of[*half as usize / 3]].closed = false;
    }

    // Open parts: the side on which most of the area is.
    for part in parts.iter().filter(|part| !part.closed) {
        let area = |face: &u32| mesh.corners(*face as usize).map_or(0.0, area);
        let signed = |face: &u32| {
            if reversed[*face as usize] { -area(face) } else { area(face) }
        };
        if part.faces.iter().map(signed).sum::<f64>() < 0.0 {
            flip(&mut reversed, part);
        }
    }
    apply(mesh, &reversed);

    // Closed parts: outwards at an even depth, inwards at an odd one.
    let closed: Vec<&Part> = parts.iter().filter(|part| part.closed).collect();
    let faces: Vec<&[u32]> = closed.iter().map(|part| part.faces.as_slice()).collect();
    let depths = nesting::depths(mesh, &faces)?;
    let mut inside_out = vec![false; mesh.triangles.len()];
    for (part, depth) in closed.iter().zip(depths) {
        if (volume(mesh, &part.faces) > 0.0) != (depth % 2 == 0) {
            flip(&mut inside_out, part);
            flip(&mut reversed, part);
        }
    }
    apply(mesh, &inside_out);

    // The report.
    let count = reversed.iter().filter(|&&is| is).count();
    if count > 0 {
        let touched = |part: &&Part| part.faces.iter().any(|&face| reversed[face as usize]);
        let some = parts.iter().filter(touched).count();
        let all = parts.len();
        let end = "connected parts pointed the wrong way";
        report.push(format!("reversed: {count} faces in {some} of {all} {end}"));
    }
    if parts.len() > 1 {
        let (all, closed) = (parts.len(), closed.len());
        report.push(format!("parts: {all} connected parts, {closed} of them closed"));
    }
    if edges.open > 0 {
        let end = "edges have one face only; light is transported as if the gaps were not there";
        report.push(format!("open: {} {end}", edges.open));
    }
    if edges.crowded > 0 {
        let end = "edges have three faces or more; the parts that meet there count as open";
        report.push(format!("crowded: {} {end}", edges.crowded));
    }
    if !disagreeing.is_empty() {
        let count = disagreeing.len();
        let end = "edges have faces that cannot agree on a side, as on a Moebius strip";
        report.push(format!("one-sided: {count} {end}"));
    }
    Ok(())
}

/// The connected parts, each with its faces in ascending order, and the part of each face. `reversed` becomes true for
/// faces that must be flipped to agree with the first face of their part.
fn split(triangles: &[[u32; 3]], edges: &Edges, reversed: &mut [bool]) -> (Vec<Part>, Vec<usize>) {
    const UNSEEN: usize = usize::MAX;
    let mut part_of = vec![UNSEEN; triangles.len()];
    let mut parts = Vec::new();
    for first in (0..).take(triangles.len()) {
        if part_of[first as usize] != UNSEEN {
            continue;
        }
        part_of[first as usize] = parts.len();
        let mut part = Part { faces: vec![first], closed: true };
        let mut next = 0;
        while let Some(&face) = part.faces.get(next) {
            next += 1;
            for half in 3 * face..3 * face + 3 {
                let twin = edges.twin[half as usize];
                if twin == NONE {
                    part.closed = false;
                } else if part_of[twin as usize / 3] == UNSEEN {
                    // Consistent faces traverse their shared edge in opposite directions.
                    let same = start(triangles, half) == start(triangles, twin);
                    reversed[twin as usize / 3] = reversed[face as usize] != same;
                    part_of[twin as usize / 3] = parts.len();
                    part.faces.push(twin / 3);
                }
            }
        }
        part.faces.sort_unstable();
        parts.push(part);
    }
    (parts, part_of)
}

/// One half-edge of each edge whose two faces are still inconsistent.
fn disagreements(triangles: &[[u32; 3]], edges: &Edges, reversed: &[bool]) -> Vec<u32> {
    let twins = (0..).zip(edges.twin.iter().copied());
    let disagree = |&(half, twin): &(u32, u32)| {
        twin != NONE && half < twin && {
            let same = start(triangles, half) == start(triangles, twin);
            same == (reversed[half as usize / 3] == reversed[twin as usize / 3])
        }
    };
    twins.filter(disagree).map(|(half, _)| half).collect()
}

fn flip(flags: &mut [bool], part: &Part) {
    for &face in &part.faces {
        flags[face as usize] = !flags[face as usize];
    }
}

fn apply(mesh: &mut Mesh, reversed: &[bool]) {
    fn turn<T>(corners: &mut [[T; 3]], reversed: &[bool]) {
        for (corners, _) in corners.iter_mut().zip(reversed).filter(|(_, reversed)| **reversed) {
            corners.swap(1, 2);
        }
    }
    turn(&mut mesh.triangles, reversed);
    turn(mesh.uvs.as_deref_mut().unwrap_or_default(), reversed);
    turn(mesh.corner_normals.as_deref_mut().unwrap_or_default(), reversed);
}

fn area([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length() / 2.0
}

/// Six times the volume of a closed part, relative to one of its own corners for precision.
fn volume(mesh: &Mesh, faces: &[u32]) -> f64 {
    let corners = || faces.iter().filter_map(|&face| mesh.corners(face as usize));
    let apex = corners().next().map_or(DVec3::ZERO, |[a, ..]| a);
    corners().map(|[a, b, c]| (a - apex).dot((b - apex).cross(c - apex))).sum()
}

#[cfg(test)]
mod tests;
