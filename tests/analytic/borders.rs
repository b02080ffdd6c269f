//! The borders of clusters against a count of their triangles' edges.

use milkglass::internals::hierarchy::border::{Borders, borders};
use milkglass::internals::hierarchy::{Tree, face_cluster, median};
use milkglass::scene::Shape;

/// The border of a node from the triangles below it, edge by edge.
fn counted(tree: &Tree, triangles: &[[u32; 3]], node: usize) -> Vec<[u32; 2]> {
    let first = (0..node).filter(|&i| tree.is_leaf(i)).count();
    let faces = (node..tree.skip[node] as usize).filter(|&i| tree.is_leaf(i)).count();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for &[a, b, c] in &triangles[first..first + faces] {
        for edge in [[a, b], [b, c], [c, a]] {
            match edges.iter().position(|&[from, to]| [to, from] == edge) {
                Some(back) => drop(edges.swap_remove(back)),
                None => edges.push(edge),
            }
        }
    }
    edges.sort_unstable();
    edges
}

#[test]
fn borders_are_the_edges_that_nothing_cancels() {
    for shape in [Shape::Sphere, Shape::Slab] {
        let mut mesh = shape.build(if shape == Shape::Sphere { 2 } else { 6 });
        // Two triangles on top of each other, and an edge of four triangles.
        let [a, b, _] = mesh.triangles[0];
        mesh.triangles.extend([mesh.triangles[5], [a, b, 9], [b, a, 11]]);
        for tree in [
            median::build(&mesh.positions, &mesh.triangles, 1),
            face_cluster::build(&mesh.positions, &mesh.triangles).0,
        ] {
            let ordered: Vec<[u32; 3]> = tree.leaves().map(|leaf| mesh.triangles[tree.face[leaf] as usize]).collect();
            let all = borders(&tree, &ordered, usize::MAX);
            for node in 0..tree.nodes() {
                let [first, count] = all.runs[node].map(|n| n as usize);
                let mut own = all.edges[first..first + count].to_vec();
                own.sort_unstable();
                let expected = if tree.is_leaf(node) { Vec::new() } else { counted(&tree, &ordered, node) };
                assert_eq!(own, expected, "{shape:?} node {node}");
            }
            let few = borders(&tree, &ordered, 8);
            assert!(few.runs.iter().all(|run| run[1] <= 8) && few.runs.iter().any(|run| run[1] == 4));
        }
    }
}

#[test]
fn a_closed_surface_has_none() {
    let mesh = Shape::Sphere.build(2);
    let tree = median::build(&mesh.positions, &mesh.triangles, 1);
    let ordered: Vec<[u32; 3]> = tree.leaves().map(|leaf| mesh.triangles[tree.face[leaf] as usize]).collect();
    assert_eq!(borders(&tree, &ordered, usize::MAX).runs[0][1], 0);
    assert_eq!(borders(&Tree::default(), &[], 9), Borders::default());
}
