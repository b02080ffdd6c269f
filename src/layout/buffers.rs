//! The buffers of a frame. A buffer's place in this list is its binding in every shader.

use super::*;

buffers! {
    /// The numbers that hold for a whole frame of an object.
    object_params: ObjectParams, object;
    /// The lights.
    lights: Light, light;
    /// Whether each light reaches each triangle: a bit each, `object_params.shadow_words` words a triangle.
    lit: u32, shadow;
    /// The lights as pixels see them: as many points or rays of each as one sample of a pixel takes.
    pixel_lights: Light, light;
    /// Whether each of those reaches the surface that a pixel shows: a bit each, `camera.shadow_words` a pixel.
    pixel_lit: u32, pixel;
    /// Not 0 if a driver ended a shadow ray's loop early; one element.
    cut_short: u32, scene;
    /// The environment's image, rows from the top.
    sky: [f32; 3], pixel;
    /// Integrals over its rows.
    sky_rows: SkyRow, row;
    /// Integrals over its columns.
    sky_columns: SkyColumn, column;
    /// The octahedral map of where it is bright; empty if that is nearly even, or nothing reflects it.
    sky_cells: SkyCell, cell;
    /// Sums of image times harmonic, nine a block of pixels; the first nine are the environment's coefficients.
    harmonics: [f32; 3], patch;
    /// The camera; one element.
    camera: Camera, scene;
    /// Positions of all objects' vertices, each object's in its own frame: about its centre, a scene of unit extent.
    positions: [f32; 3], point;
    /// The same before any deformation, where there is one.
    rest: [f32; 3], vertex;
    /// Unit vertex normals before any deformation, area-weighted.
    rest_normals: [f32; 3], vertex;
    /// Unit vertex normals of long triangles that were divided: those of the whole ones, interpolated; 0 for objects
    /// without any. Empty if none were divided.
    whole_normals: [f32; 3], vertex;
    /// The deformations of the objects, in the order in which they apply.
    deforms: Deform, deform;
    /// For each morph and each vertex of its object, the displacement to its place in the other mesh.
    morphs: [f32; 3], way;
    /// The vertices that follow joints, as they are bound; empty if none do.
    skin_vertices: SkinVertex, vertex;
    /// The joints that each vertex follows.
    skin_joints: SkinJoint, joint;
    /// Displacements of each vertex by its morph targets.
    skin_targets: [f32; 3], way;
    /// Weights of morph targets.
    skin_weights: f32, weight;
    /// The matrices of the joints.
    skin_matrices: SkinMatrix, matrix;
    /// Where joints place the vertices, each in its object's own frame.
    skinned: [f32; 3], vertex;
    /// Indices in `positions` of each triangle's corners, in the order of the tree's leaves. All other indices of an
    /// object count from its own first vertex, face, node and block.
    triangles: [u32; 3], face;
    /// Where each vertex's entries in `corners` begin; one more at the end.
    corner_starts: u32, start;
    /// The triangles around each vertex.
    corners: u32, corner;
    /// The vertices in the order of their first triangles; empty unless curvature may be smoothed.
    vertex_order: u32, vertex;
    /// Texture coordinates of each triangle's corners; empty if there is no texture.
    corner_uvs: CornerUvs, face;
    /// Texels of the texture, linear, rows from the top; empty if there is none.
    texels: [f32; 3], texel;
    /// The tree.
    topology: Topology, node;
    /// The leaf node of each triangle.
    leaves: u32, face;
    /// Marks of the clusters that have one child done, while invocations climb from all triangles; 0 before and after.
    arrivals: u32, node;
    /// All nodes, sorted by chunk and level, clusters before triangles, by index.
    order: u32, node;
    /// Bounding boxes in the object's own frame, and the order in which rays visit the trees of all objects.
    bounds: Bounds, node;
    /// The children of wide nodes, `WIDE` each: a node of all objects, or `NONE`, and its wide node times `WIDE`.
    wide_links: [u32; 2], child;
    /// The boxes of those children in the scene, with their second number as `next`; empty, with `face` 0, where there
    /// is no child.
    wide_boxes: Bounds, child;
    /// Clusters.
    clusters: Cluster, node;
    /// Unit vertex normals, area-weighted.
    normals: [f32; 3], vertex;
    /// Positions in the scene, where objects are turned or shifted; otherwise empty, and `positions` are bound instead.
    placed_positions: [f32; 3], point;
    /// Vertex normals in the scene; empty, with `normals` instead, likewise.
    placed_normals: [f32; 3], vertex;
    /// Bounding boxes in the scene; empty, with `bounds` instead, likewise.
    placed_bounds: Bounds, node;
    /// The curvature of the surface at each vertex.
    curvature: Curvature, vertex;
    /// Integrals of curvature over each cluster.
    curvature_sums: CurvatureSum, node;
    /// kappa at each vertex, smoothed.
    smooth_kappa: f32, vertex;
    /// The attributes of a vertex that local shading reads: its unit normal, 16 bits a component, and 16 bits of kappa.
    packed_normals: [u32; 2], vertex;
    /// The CDRF over a grid: rows of rising sigma, in each the cosine from -1 to 1.
    cdrf_grid: f32, entry;
    /// Its cells: the value at a corner, and how it changes across, up and both, in 13, 6, 7 and 6 bits.
    cdrf_cells: u32, cell;
    /// The objects whose light is blurred over their texture coordinates.
    unwrappings: Unwrapping, unwrapping;
    /// What their texels show, rows from the top.
    texel_hits: TexelHit, texel;
    /// Lengths that a texel spans along the rows and down the columns.
    stretch: [f32; 2], texel;
    /// Each object's Gaussians, narrowest first: weights of the channels, then how far the sheet before is blurred.
    gaussians: [f32; 4], gaussian;
    /// A sheet of the light that enters at each texel, and one for each Gaussian: light, and 1 on a surface.
    irradiance_maps: [f32; 4], texel;
    /// A sheet blurred along its rows.
    blurred_rows: [f32; 4], texel;
    /// Irradiance that enters each triangle, E of equation 5, times a texture at the entry.
    irradiance: [f32; 3], face;
    /// Area-weighted mean irradiance of each cluster.
    cluster_irradiance: [f32; 3], node;
    /// The blocks of receivers.
    blocks: Block, block;
    /// The receivers: the triangles' centroids, or the places that pixels show, `BLOCK_RECEIVERS` a tile.
    receiver_positions: [f32; 3], receiver;
    /// The blocks' bounding spheres.
    spheres: Sphere, block;
    /// Emitters' moments, a part a group of channels: one a node, rounded up.
    moments: Moment, group;
    /// Their second moments, likewise.
    second_moments: SecondMoments, group;
    /// The nodes as the walk over emitters sees them, a part a group of channels: one a node, rounded up.
    emitters: Emitter, group;
    /// Distances beyond which one expansion of a node serves a whole block, for each of the `BLOCK_CLASSES`.
    expansion_distances: [f32; 4], group;
    /// The receivers of the coarse solution.
    samples: Sample, sample;
    /// Root of the area-weighted mean of B^2, from the coarse solution; one element.
    reference_level: [f32; 3], scene;
    /// How far a link's error reaches: for each error law a table of distances over the logarithm of its value.
    ranges: f32, table;
    /// Where the lists of each block lie in its batch, a part a batch and group.
    runs: Runs, batch;
    /// The blocks of a batch that take area points or the edge form, by their place in the batch.
    near: u32, batch;
    /// Groups to dispatch for them: of 64 receivers each, then of a block each; then their number. A part is 64
    /// elements for the sake of its offset.
    near_groups: [u32; 3], batch;
    /// What `link` decides until its lists are placed. Where one invocation walks for a block: the first LINK_KEPT - 1
    /// emitters that it lists, in the order of its walk, and behind them the last node that it visited: nodes, and how
    /// each is taken. Where a group does: all of them, in parts (`glsl/transport/blocks/link/noted.glsl`).
    decisions: u32, table;
    /// The blocks' lists, one after the other: nodes.
    entries: u32, batch;
    /// The radiosity that distant emitters give each block.
    expansions: Expansion, block;
    /// Radiosity of each receiver from its block's direct list; of diffusion from its area and edge lists, too.
    received: [f32; 3], receiver;
    /// Radiosity of each receiver from its block's area list; only where there is one.
    area_received: [f32; 3], receiver;
    /// Radiosity of each receiver from its block's edge list; only where there is one.
    edge_received: [f32; 3], receiver;
    /// Which channels of each block have an area list, bits 0 to 2, and an edge list, bits 3 to 5.
    near_channels: u32, block;
    /// Estimated error of the radiosity of each receiver.
    estimate: [f32; 3], receiver;
    /// Squared centroid distances beyond which 1, 3, 6, 12 area points serve for a triangle.
    reach: [f32; 4], face;
    /// Scheme `links`: the first edge of each cluster's border and their number, 0 for triangles and for borders too
    /// long; empty where clusters are not projected.
    borders: [u32; 2], node;
    /// The borders' edges: two vertices as in `triangles`, the cluster on their left.
    border_edges: [u32; 2], border;
    /// Squared centroid distance beyond which one sample serves for a cluster; 0 where there is no border.
    cluster_reach: f32, node;
    /// Each receiver's lists.
    spans: Span, node;
    /// Emitters that a receiver hands down to its children.
    handed: u32, hand;
    /// How full the lists of each object are.
    counters: ListCounters, object;
    /// The links of a chunk, by receiver.
    links: Link, chunk;
    /// Form factor of each link, per channel.
    factors: [f32; 3], chunk;
    /// Indices of the links that take area points.
    area_links: u32, chunk;
    /// Indices of the links that take the edge form.
    edge_links: u32, chunk;
    /// Positions of all objects' vertices for which kept links were made.
    kept_positions: [f32; 3], point;
    /// The clusters for which kept links were made.
    kept_clusters: Cluster, node;
    /// What has changed below each cluster since then: bits `ALTERED_`.
    change_flags: u32, node;
    /// Of each receiver: its part of `added_links` (link), of `removed_links` (area), of `due_links` or, before, the
    /// place that its links move to (edge), and of `handed`.
    edits: Span, node;
    /// Receivers of a chunk that have something to do, from the place on that the chunk has in `order`: those whose
    /// links are merged, and after that those whose links are summed again.
    active_receivers: u32, node;
    /// Emitters of links that are new, or touch an altered cluster.
    added_links: u32, edit;
    /// Emitters of links that are removed.
    removed_links: u32, edit;
    /// Not 0 if a link's form factor waits to be computed.
    stale: u32, chunk;
    /// Number of each receiver's links whose form factors wait.
    stale_counts: u32, node;
    /// Links whose form factor is computed in this frame, by receiver.
    due_links: u32, due;
    /// The same, sorted by quadrature rule.
    ranked_links: u32, due;
    /// Work groups to dispatch for each rule, then those of `DUE_MERGED` and `DUE_SUMMED`.
    due_groups: [u32; 3], rank;
    /// Radiosity gathered at each node's own links.
    gathered: [f32; 3], node;
    /// How light walks through each object.
    walk_params: WalkParams, object;
    /// The light that enters each triangle of an object and those before it, in integers.
    entry_sums: EntrySum, face;
    /// The same of blocks of triangles.
    entry_blocks: EntryBlock, walk;
    /// Of each cell of a grid around an object, `CLEARANCE_SIDE` a side, its distance to the surface, or less.
    clearance: f32, walk;
    /// The photons under way in an object, three slots in turn of red, green, blue.
    photons: Photon, walk;
    /// Where their weight has gone.
    balances: WalkBalance, walk;
    /// What has left through each triangle.
    exits: ExitSum, face;
    /// Standard error of the radiosity that a walk found.
    walk_noise: [f32; 3], face;
    /// Where the light that enters each triangle collides first.
    deposits: Deposit, face;
    /// Each cluster's layers: places and charges.
    layer_places: LayerPlace, node;
    /// Their first moments.
    layer_firsts: LayerFirst, node;
    /// Their second moments: squares.
    layer_squares: LayerSecond, node;
    /// Their second moments: products.
    layer_products: LayerSecond, node;
    /// What a near triangle's layers of charge 1 give at each receiver of a block: of the last near triangles of each
    /// block, blocks in the order of `near`.
    near_layers: [f32; 3], batch;
    /// An orthonormal basis of the Krylov space of each object, in the mean over its area.
    krylov: [f32; 3], vectors;
    /// The small system of each object: the operator in that basis, made triangular, and what belongs to it.
    small_system: [f32; 3], small;
    /// The solution at each triangle, not clamped.
    solution: [f32; 3], face;
    /// Radiosity of each receiver, B of equation 4.
    radiosity: [f32; 3], receiver;
    /// Radiosity averaged at each vertex.
    vertex_radiosity: [f32; 3], vertex;
    /// What each pixel's ray hits.
    hits: Hit, pixel;
    /// The receiver that each pixel shows, among those of its object.
    seen: u32, pixel;
    /// Linear radiance of each pixel.
    radiance: [f32; 3], pixel;
    /// Its mean over the samples so far; empty where there is one sample a pixel.
    mean: [f32; 3], pixel;
    /// The least radiance that is shown as 1, as 2, ... as 255.
    tones: f32, tone;
    /// Each pixel as it is shown: red, green, blue, 8 bits each from the lowest.
    shown: u32, pixel;
    /// The objects that have layers beneath their surface.
    layerings: Layering, layering;
    /// Their layers.
    layer_media: Layer, layer;
    /// Where their triangles are in depth maps laid out by islands: of those whose texture coordinates have seams.
    islands: Island, face;
    /// Depths of the layers' lower interfaces, four a texel, rows from the top.
    depths: [f32; 4], texel;
    /// What scatters light once in objects whose material asks for it.
    scattering_media: ScatteringMedium, medium;
    /// The view rays beneath the points that some pixels show.
    inner_rays: InnerRay, ray;
    /// The lights that shine into layers and scattering media, the environment as directional lights.
    layer_lights: Light, beam;
    /// The vertices of each cluster.
    vertex_moments: VertexMoments, node;
    /// The plane fitted to the surface around each vertex: its unit normal, and its height over the vertex along that.
    planes: [f32; 4], vertex;
    /// Form factors to evaluate one by one.
    queries: Query, query;
    /// Their values: radial, then displaced sources (Table 1).
    answers: [f32; 3], query;
}
