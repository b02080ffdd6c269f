//! The structs that host and device share.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { frame_records:
    /// The parameters of an object that hold in the whole frame, padded so that it can be bound by itself. Lengths are
    /// internal: the scene has unit extent.
    ObjectParams {
        /// Its first triangle among those of all objects.
        first_face: u32,
        /// Its first node likewise.
        first_node: u32,
        /// Its first vertex likewise.
        first_vertex: u32,
        /// Its first deformation among those of all objects.
        first_deform: u32,
        /// Number of those.
        deforms: u32,
        /// The first node of the next object; of the last object, the number of nodes of all.
        next_node: u32,
        /// Number of nodes of all objects, gaps between them included.
        scene_nodes: u32,
        /// Its first receiver among those of all objects.
        first_receiver: u32,
        /// Not 0 if its receivers are the places that pixels show, 0 if they are its triangles.
        by_pixel: u32,
        /// Whether light enters it, and how it is lit if none does: an `OPAQUE_`.
        opaque: u32,
        /// Share of the arriving light that an opaque object reflects diffusely, per channel.
        albedo: [f32; 3],
        /// Number of vertices.
        vertices: u32,
        /// Number of triangles.
        faces: u32,
        /// Number of nodes of the tree, 2 faces - 1.
        nodes: u32,
        /// Number of lights.
        lights: u32,
        /// Words of `lit` for each face: a bit for each light that casts shadows, and for each ray to the environment.
        shadow_words: u32,
        /// Not 0 if both sides of a face receive light.
        two_sided: u32,
        /// Size of the environment's image, in pixels.
        sky: [u32; 2],
        /// Turns from the left edge of that image to -z in the scene: 0.5 where the environment is not rotated.
        sky_turn: f32,
        /// What the surface reflects: a `REFLECTION_`.
        reflection: u32,
        /// The lobe's exponent, or alpha of the microfacets.
        roughness: f32,
        /// Where light is multiplied by the texture: bits `TEXTURE_`.
        texture_side: u32,
        /// How the texture continues beyond its left and right edges, and beyond its lower and upper ones: a `WRAP_`
        /// each.
        texture_wrap: [u32; 2],
        /// Its width and height, in texels.
        texture_size: [u32; 2],
        /// Its first texel.
        texture_first: u32,
        /// The factors of the environment's harmonics of degree 0, per channel: integrals of Fresnel transmittance and
        /// cosine.
        zonal_0: [f32; 3],
        /// The same of degree 1.
        zonal_1: [f32; 3],
        /// The same of degree 2.
        zonal_2: [f32; 3],
        /// Threshold epsilon_1 of section 5.2: largest deviation of the solid angle over a receiver, steradian.
        receiver_angle: f32,
        /// Threshold epsilon_2 of section 5.2: largest solid angle of an emitter, steradian.
        emitter_angle: f32,
        /// Square of the smallest planarity A'/A (section 5.1.1) of a cluster that may emit.
        planarity: f32,
        /// Room for links in one chunk.
        link_capacity: u32,
        /// Room for links whose form factor takes area points, in one chunk.
        area_capacity: u32,
        /// Room for links whose form factor takes the edge form, in one chunk.
        edge_capacity: u32,
        /// Room for emitters handed down from receiver to receiver.
        hand_capacity: u32,
        /// Dipole strength alpha' / (4 pi), per channel.
        strength: [f32; 3],
        /// Effective transport coefficient sigma_tr, per channel, 1/length.
        sigma: [f32; 3],
        /// Depth of the real source z_r, per channel.
        z_real: [f32; 3],
        /// Height of the virtual source z_v, per channel.
        z_virtual: [f32; 3],
        /// Relative index of refraction, per channel.
        eta: [f32; 3],
        /// Factor on light that leaves: 1, or 1 / (1 - F_ext), per channel.
        exit: [f32; 3],
        /// Number of blocks of receivers.
        blocks: u32,
        /// Number of blocks that its area is divided by for the size of a usual one.
        usual_blocks: u32,
        /// Room for list entries in one batch.
        entry_capacity: u32,
        /// Room for triangles of one block that `gather` takes one by one, a multiple of what one dispatch takes.
        near_capacity: u32,
        /// Largest error of one link, in units of the reference level.
        link_error: f32,
        /// Rounding of values and of positions to `f32`, per channel, as a share of the radiosity.
        rounding: [f32; 3],
        /// Irradiance of each channel as a multiple of its group's lead channel.
        tint: [f32; 3],
        /// chi below which 1 (with second moments), 3, 6 and 12 area points serve.
        ladder: [f32; 4],
        /// Radius around a vertex within which a plane is fitted to the surface if it has layers beneath it, else 0.
        fit_radius: f32,
        /// Local shading: standard deviation of the scattering along the surface, per channel, length.
        sigma_0: [f32; 3],
        /// Local shading: share of the light that comes back from a flat surface, per channel.
        diffuse: [f32; 3],
        /// Local shading: what kappa is, a `KAPPA_`.
        kappa: u32,
        /// Local shading: width and height of the map of sigma_0, in texels; 0 where there is none.
        sigma_0_size: [u32; 2],
        /// Its first texel.
        sigma_0_first: u32,
        /// Its number in `unwrappings`, from 1; 0 where its light is not blurred over texture coordinates.
        irradiance_map: u32,
        /// What turns it from its own frame into the scene: the first row of a matrix.
        turn_x: [f32; 3],
        /// The second row.
        turn_y: [f32; 3],
        /// The third row.
        turn_z: [f32; 3],
        /// What shifts it after that.
        shift: [f32; 3],
        /// Diffusion: the distance z_b beyond the surface at which light vanishes, extrapolated, per channel, length.
        boundary: [f32; 3],
        /// Diffusion: mean depth of the first collision of light from all around, per channel, length.
        sky_depth: [f32; 3],
        /// Wide nodes at the top: of several objects those that have their roots as children, of one its own root.
        wide_tops: u32,
        /// Alpha of the second lobe's microfacets.
        second_roughness: f32,
        /// Share of the second lobe in the reflection, 0 to 1: 0 where there is one lobe.
        second_share: f32,
        /// The square of the cosine at which facets of a surface that is seen edge-on are seen; 0 of a smooth surface.
        facet_tilt: f32,
        /// Unused.
        padding: [u32; 2],
        /// Unused.
        last_padding: u32,
        /// Joints that each of its vertices follows; 0 if it follows none.
        skin_joints: u32,
        /// The first element of `skin_joints`.
        first_joint: u32,
        /// The first one of `skin_matrices`.
        first_matrix: u32,
        /// Morph targets of each of its vertices.
        skin_targets: u32,
        /// The first element of `skin_targets`.
        first_target: u32,
        /// The first one of `skin_weights`.
        first_weight: u32,
        /// Not 0 if near clusters are integrated over their projection (section 5.1.1).
        projected: u32,
        /// Unused.
        more_padding: [u32; 2],
        /// Local shading: radius within which curvature is smoothed, length; 0 if it is not.
        curvature_radius: f32,
        /// Most form factors that a frame may compute over links that are kept.
        budget: u32,
        /// Room for links that a frame makes or undoes in one chunk.
        edit_capacity: u32,
    }
    /// A block of receivers: the faces of a maximal node of at most 16, or what a tile of 4 x 4 pixels shows of an
    /// object in one piece.
    Block {
        /// The node, where it is one.
        node: u32,
        /// Its first receiver.
        first: u32,
        /// Number of its receivers.
        count: u32,
    }
    /// The sphere around a block's receivers.
    Sphere {
        /// Middle of the box around the receivers.
        center: [f32; 3],
        /// Distance of the farthest receiver.
        radius: f32,
        /// Mean square of the receivers' distances, in units of a usual block's.
        relative_moment: f32,
    }
    /// Moments of the light that enters a cluster, by the irradiance of its group's lead channel.
    Moment {
        /// Centroid of the light (order 1 and 2) or of the area.
        center: [f32; 3],
        /// W: the sum of area times irradiance.
        weight: f32,
    }
    /// Second moments of that light, in a buffer of their own, so that millions of nodes fit a binding.
    SecondMoments {
        /// Second moments about the centre per weight: xx, yy, zz.
        diagonal: [f32; 3],
        /// Bound on the distance of any point of the cluster from the centre.
        radius: f32,
        /// Second moments: yz, zx, xy.
        mixed: [f32; 3],
        /// Distance beyond which the coarse solution takes the cluster as one.
        coarse: f32,
    }
    /// A node as the walk over emitters sees it. Distances run from its centre to a block's sphere.
    Emitter {
        /// The moments' centre, then the distance beyond which its light is left out, far below 0 if it emits none.
        place: [f32; 4],
        /// The distance beyond which one link serves; for a triangle, one sample with its second moment.
        accept: f32,
        /// For a triangle, the distance beyond which 6 area points serve.
        area: f32,
        /// The first node after its subtree.
        skip: u32,
        /// Its second child, 0 for a triangle. The record has 32 bytes: two loads.
        right: u32,
    }
    /// Where a block's lists lie, one after the other.
    Runs {
        /// First entry.
        first: u32,
        /// Emitters expanded once for the whole block.
        expanded: u32,
        /// Emitters evaluated for each receiver.
        direct: u32,
        /// Triangles that take area points.
        area: u32,
        /// Triangles that take the edge form.
        edge: u32,
        /// Emitters left out because their light is negligible.
        dropped: u32,
    }
    /// Radiosity of a block as a quadratic in the offset from its centre, per channel.
    Expansion {
        /// Value at the centre.
        value: [f32; 3],
        /// Derivative along x.
        x: [f32; 3],
        /// Derivative along y.
        y: [f32; 3],
        /// Derivative along z.
        z: [f32; 3],
        /// Second derivative.
        xx: [f32; 3],
        /// Second derivative.
        yy: [f32; 3],
        /// Second derivative.
        zz: [f32; 3],
        /// Second derivative.
        yz: [f32; 3],
        /// Second derivative.
        zx: [f32; 3],
        /// Second derivative.
        xy: [f32; 3],
        /// Squared estimate of the emitters' error, and of what was dropped.
        error: [f32; 3],
        /// Squared estimate of the expansion's error at the block's radius; it grows with the cube of the offset.
        bend: [f32; 3],
    }
    /// A node's place in the tree, stored depth first: the left child of `i` is `i + 1`.
    Topology {
        /// The first node after this subtree; also the right child of the parent's left child.
        skip: u32,
        /// The parent; `NONE` at the root.
        parent: u32,
        /// The triangle of a leaf, or `NONE`.
        face: u32,
    }
    /// A node's bounding box, and the node that a ray visits next.
    Bounds {
        /// Smallest corner.
        low: [f32; 3],
        /// The first node after its subtree, among those of all objects.
        next: u32,
        /// Largest corner.
        high: [f32; 3],
        /// The triangle of a leaf among those of all objects, or `NONE`.
        face: u32,
    }
    /// A node as a cluster of faces.
    Cluster {
        /// Area-weighted centroid.
        center: [f32; 3],
        /// Total area A.
        area: f32,
        /// Vector area: the sum of A_k N_k; its length is the projected area A' of section 5.1.1.
        normal: [f32; 3],
        /// tau: trace of the second moment about the centroid, per area.
        moment_trace: f32,
    }
}
