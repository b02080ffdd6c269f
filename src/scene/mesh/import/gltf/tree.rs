//! The nodes of a glTF file: which are shown, and where they stand.

use super::document::{Document, gone};
use crate::error::Input;
use crate::scene::range::Checked;
use glam::{DMat4, DQuat, DVec3};

/// The order of the nodes, parents first, and which belong to the scene.
pub(super) struct Tree {
    /// All nodes, parents before their children.
    pub order: Vec<usize>,
    /// The parent of each node.
    parent: Vec<Option<usize>>,
    /// Whether a node belongs to the scene.
    pub shown: Vec<bool>,
}

/// A node's own transform, and the weights of its morph targets.
#[derive(Debug, Clone)]
pub(super) struct Local {
    /// Its translation.
    pub translation: DVec3,
    /// Its rotation.
    pub rotation: DQuat,
    /// Its scale.
    pub scale: DVec3,
    /// The whole transform, if it is given as a matrix.
    matrix: Option<DMat4>,
    /// Weights of morph targets.
    pub weights: Vec<f64>,
}

impl Tree {
    /// The tree of a file's nodes. The file's scene is shown, or else its first one with nodes; without scenes, all
    /// nodes.
    pub fn of(document: &Document) -> Checked<Self> {
        let nodes = &document.root.nodes;
        let mut parent = vec![None; nodes.len()];
        for (number, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten().map(|child| child.value()) {
                let Some(place) = parent.get_mut(child) else { return Err(gone("node", child)) };
                if place.replace(number).is_some() {
                    let fault = Input::new("a node has two parents").key(format!("nodes.{child}"));
                    return Err(fault.expected("a tree of nodes"));
                }
            }
        }
        let root = |number: &usize| parent[*number].is_none();
        let mut order: Vec<usize> = (0..nodes.len()).filter(root).collect();
        let mut next = 0;
        while let Some(&number) = order.get(next) {
            order.extend(nodes[number].children.iter().flatten().map(|child| child.value()));
            next += 1;
        }
        if order.len() < nodes.len() {
            let round = nodes.len() - order.len();
            let fault = Input::new("nodes are their own ancestors").found(format!("{round} such nodes"));
            return Err(fault.expected("a tree of nodes"));
        }
        let scenes = &document.root.scenes;
        let mut shown = vec![false; nodes.len()];
        let chosen = document.root.scene.map(|scene| scene.value());
        // Without a choice, the first scene that shows something.
        let full = || scenes.iter().position(|scene| !scene.nodes.is_empty()).unwrap_or(0);
        match (chosen, scenes.get(chosen.unwrap_or_else(full))) {
            (_, Some(scene)) => {
                for node in scene.nodes.iter().map(|node| node.value()) {
                    *shown.get_mut(node).ok_or_else(|| gone("node", node))? = true;
                }
            }
            (Some(scene), None) => return Err(gone("scene", scene)),
            (None, None) => shown.fill(true),
        }
        for &number in &order {
            shown[number] |= parent[number].is_some_and(|parent: usize| shown[parent]);
        }
        Ok(Self { order, parent, shown })
    }

    /// The nodes of the scene, parents first.
    pub fn shown(&self) -> impl Iterator<Item = usize> {
        self.order.iter().copied().filter(|&number| self.shown[number])
    }

    /// Transforms from each node to the scene.
    pub fn world(&self, locals: &[Local]) -> Vec<DMat4> {
        let mut world = vec![DMat4::IDENTITY; locals.len()];
        for &number in &self.order {
            let above = self.parent[number].map_or(DMat4::IDENTITY, |parent| world[parent]);
            world[number] = above * locals[number].matrix();
        }
        world
    }
}

impl Local {
    /// The transforms of all nodes as the file has them, at rest.
    pub fn rest(document: &Document) -> Vec<Self> {
        let three = |given: Option<[f32; 3]>, usual: DVec3| given.map_or(usual, |v| DVec3::from(v.map(f64::from)));
        let local = |node: &gltf::json::Node| Self {
            translation: three(node.translation, DVec3::ZERO),
            rotation: node.rotation.map_or(DQuat::IDENTITY, |q| quaternion(q.0.map(f64::from))),
            scale: three(node.scale, DVec3::ONE),
            matrix: node.matrix.map(|matrix| DMat4::from_cols_array(&matrix.map(f64::from))),
            weights: {
                let of_mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value())?.weights.as_ref());
                let weights = node.weights.as_ref().or(of_mesh);
                weights.into_iter().flatten().map(|&weight| f64::from(weight)).collect()
            },
        };
        document.root.nodes.iter().map(local).collect()
    }

    fn matrix(&self) -> DMat4 {
        let composed = || DMat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation);
        self.matrix.unwrap_or_else(composed)
    }
}

/// The quaternion x y z w with length 1; the identity if its length is 0 or not finite.
pub(super) fn quaternion(values: [f64; 4]) -> DQuat {
    let q = DQuat::from_array(values);
    let length = q.length();
    if length.is_finite() && length > 0.0 { q / length } else { DQuat::IDENTITY }
}
