//! Sizes, limits and coefficients that host and device share.

use super::{Constant, Shared};

constants! {
    /// Every shared size, limit and coefficient; each is used by some shader and by some Rust file.
    numbers:

    /// In place of an index: there is no such element.
    NONE: u32 = u32::MAX;
    /// In place of the triangle that a ray hits: the driver ended the walk early. lavapipe ends an invocation's loops,
    /// silently, after 65,535 iterations in total.
    UNFINISHED: u32 = u32::MAX - 1;

    /// Invocations of a work group, unless a kernel declares another number.
    GROUP_SIZE: u32 = 64;
    /// The specialization constant that sets another number of invocations, where a kernel allows that.
    GROUP_ID: u32 = 100;
    /// The specialization constant that tells a kernel that a subgroup runs in lockstep and needs no barrier, where it
    /// is not 0: kernels with one in a loop give wrong values on llvmpipe of Mesa 25.
    LOCKSTEP_ID: u32 = 101;
    /// The specialization constant that says how many invocations share an item: 1, or all those of a group.
    LANES_ID: u32 = 102;
    /// At most so many invocations share an item.
    MOST_LANES: u32 = 128;
    /// The specialization constant that says how many invocations share a receiver: 1, or a group's over
    /// [`BLOCK_RECEIVERS`].
    TEAMS_ID: u32 = 103;
    /// The specialization constant that says how many invocations the group has that goes through all elements alone.
    WIDE_ID: u32 = 104;
    /// At most so many; they share 16 bytes each at most, which are all the 16 KiB that every device has.
    MOST_WIDE: u32 = 1024;
    /// The specialization constant that is not 0 where one dispatch goes through all levels of a tree.
    CLIMBS_ID: u32 = 105;
    /// The specialization constant that sets how many invocations a group has in kernels whose groups another kernel
    /// counts: more than [`GROUP_SIZE`] where each group has one block.
    COUNTED_ID: u32 = 106;
    /// Work groups in a row of a dispatch; more need a second dimension.
    GROUPS_A_ROW: u32 = 32_768;

    /// Children of a wide node, at most.
    WIDE: usize = 8;

    /// The least number of invocations that walk through a wide node together; it sets how many teams a group has room
    /// for.
    LEAST_TEAM: usize = 4;
    /// Each coordinate of the lower corner of a box that no ray meets, and of the upper one negated.
    NO_BOX: f32 = 1e30;

    /// Coefficients of sin(2 pi x) / x in x^2, from the constant one: within 1e-9 up to a quarter of a turn.
    SINE: [f32; 7] = [6.283_185_5, -41.341_7, 81.605_25, -76.705_86, 42.058_693, -15.094_643, 3.819_952_6];
    /// Twice the rounding error of a point's height over a plane, as a share of the sum with every term positive: 16 x
    /// 2^-24.
    PLANE_ROUNDING: f32 = 1.0 / 1_048_576.0;

    /// Parts along an edge of a triangle, at most, by which the texture's mean over the triangle is taken.
    TEXTURE_PARTS: u32 = 16;
    /// Pixels of the environment's image that one invocation sums, and partial sums that the next one adds up.
    SKY_BLOCK: usize = 64;
    /// The cosine towards the eye up to which a triangle's own normal may count instead of the interpolated one.
    LEAST_SEEN: f32 = 0.2;
    /// The plastic number's powers -1 and -2, times 2^32: steps of a sequence that fills the unit square evenly.
    SQUARE_STEPS: [u32; 2] = [3_242_174_889, 2_447_445_414];
    /// Cells along a side of the octahedral map of directions; its square is 2^16, since 16 bits choose a cell.
    SKY_CELLS: u32 = 256;
    /// Spherical harmonics of degree 0 to 2.
    SKY_HARMONICS: usize = 9;

    /// Largest diagonal of a cluster's box that counts as one part in smoothing curvature, as a share of the radius.
    SMOOTHING_SHARE: f32 = 0.5;
    /// Nodes that one vertex looks at in smoothing curvature until it opens no more: below the 65,535 iterations after
    /// which lavapipe ends loops, whatever the mesh.
    SMOOTHING_STEPS: u32 = 4_096;

    /// Pixels along a side of a tile.
    TILE_SIDE: u32 = 4;
    /// Receivers that fit a block; those of a tile, too.
    BLOCK_RECEIVERS: usize = 16;
    /// Blocks that the receivers of a tile are divided into.
    TILE_BLOCKS: u32 = 4;
    /// Square of the largest distance between a receiver and the first one of its block in a tile, in half widths of a
    /// pixel there.
    TILE_REACH: f32 = 1024.0;
    /// The spread of a block of a tile that is wider than that: nothing is expanded about its centre.
    UNBOUNDED_SPREAD: f32 = 1e30;
    /// Each coordinate of receivers and blocks that show nothing: farther from the object than any table of distances
    /// reaches.
    NOWHERE: f32 = 16.0;
    /// The largest spread of each class of blocks, in units of a usual block's: an emitter has a distance for each
    /// class. Blocks beyond the last class expand nothing.
    BLOCK_CLASSES: [f32; 4] = [1.0, 4.0, 16.0, 64.0];

    /// Receivers of the coarse solution: one half drawn evenly among the triangles, one half by the light that enters.
    COARSE_SAMPLES: usize = 256;
    /// chi below which the coarse solution takes a cluster as one.
    COARSE_CHI: f64 = 0.3;

    /// The smallest contrast that lists are made for.
    CONTRAST_LEAST: f32 = 1.0 / 256.0;
    /// Steps of a fourth of an octave from there: up to 2^20.
    CONTRAST_STEPS: usize = 112;
    /// The steps within an octave.
    CONTRAST_ROOTS: [f32; 4] = [1.0, 1.189_207_1, std::f32::consts::SQRT_2, 1.681_792_8];
    /// How often the light is doubled at most before it is squared.
    CONTRAST_DOUBLINGS: u32 = 100;

    /// The error laws; `LAW_MAGNITUDE` and those after it say which.
    ERROR_LAWS: usize = 5;
    /// Entries of each law's table of distances, after its largest value and its depth.
    RANGE_ENTRIES: usize = 128;
    /// Binary orders of magnitude that a table spans at most.
    RANGE_DEPTH: f64 = 60.0;
    /// The largest distance that matters in an object of unit extent.
    FARTHEST: f64 = 4.0;
    /// sigma s beyond which a channel no longer counts: e^-20 = 2e-9.
    FAINTEST: f64 = 20.0;
    /// Share of a link's allowed error below which an emitter's light is left out.
    DROPPED_SHARE: f64 = 1e-3;
    /// Share of a link's allowed error that the expansion about a block's centre may add.
    EXPANDED_SHARE: f64 = 0.3;
    /// Largest chi at which a triangle is taken by one sample.
    SAMPLE_CHI: f64 = 1.4;
    /// Largest chi at which a triangle is taken by 6 area points.
    AREA_CHI: f64 = 1.4;

    /// Direct emitters of a block at most. More would be more steps of `gather` than lavapipe's loops take: 65,535, a
    /// ninth of them to load.
    MOST_DIRECT: usize = 58_000;
    /// Places for a block's decisions until its lists are written, the last for what is not kept; what is beyond is
    /// found by a second walk. Where a group shares a walk, it notes all.
    LINK_KEPT: usize = 256;
    /// Words a block for what a group notes beside the entries of lists, ...
    NOTED_EXTRA: usize = 4;
    /// ... and entries that each part of it has, but for one of a block.
    NOTED_LEAST: usize = 384;
    /// Words of a part before its entries.
    PART_HEADER: usize = 2;
    /// Links of one receiver at most, and emitters that it hands down: more would be more than lavapipe's loops take.
    MOST_PAIRS: usize = 65_000;
    /// 2^40: keeps products of tiny areas and distances away from denormals, which a device may flush.
    FAR_FROM_DENORMAL: f32 = 1_099_511_627_776.0;
    /// Uniform samples of one triangle at most: more make a frame of a stiff object last for minutes.
    MOST_SAMPLES: u32 = 4096;
    /// Bits of a uniform sample's barycentric coordinate: exact in `f32`.
    SAMPLE_BITS: u32 = 24;

    /// The whole error estimate is this many times the root of the squares: neighbouring links err together in part.
    /// Measured, the worst of 1000 receivers of a built-in scene errs by 3 to 7 times the root.
    ESTIMATE_SAFETY: f64 = 6.5;
    /// The third order in the emitter's and the receiver's extent, squared, from the two sums that are kept.
    ESTIMATE_BOTH: f64 = 4.0;
    /// The logarithm up to which growth by nearness is followed: its square still fits `f32`.
    ESTIMATE_STEEPEST: f64 = 16.0;

    /// Gaussians that stand for the dipole's profile where light is blurred over a texture.
    GAUSSIANS: usize = 6;
    /// Texels on each side that a blur takes at least; at most eight times as many.
    BLUR_REACH: u32 = 6;
    /// The most that a texel spans: a triangle without an area in the texture is blurred nowhere.
    LONGEST_STRETCH: f64 = 1e15;
    /// The largest sigma of the CDRF's table; beyond it the last row serves, within 1.1e-3.
    CDRF_WIDEST: f64 = 3.5;
    /// The smallest number that the code of kappa holds, 1/length; the largest is 2^15, above any kappa.
    KAPPA_LEAST: f32 = 1.0 / 131_072.0;
    /// Square of twice a triangle's area up to which it has none; far above where a device may flush to 0.
    FLAT_TRIANGLE: f32 = 1e-30;
    /// The largest cotangent of a triangle's angle.
    MOST_COTANGENT: f64 = 100.0;
    /// The largest mean curvature.
    MOST_CURVATURE: f64 = 1e4;
    /// The mixed area up to which a vertex has no curvature of its own.
    LEAST_MIXED_AREA: f64 = 1e-16;

    /// Weight of a photon that starts: 2^30.
    WALK_WEIGHT: u32 = 1_073_741_824;
    /// Weight below which roulette decides whether a photon goes on with twice as much: 2^27.
    WALK_LIGHT: u32 = 134_217_728;
    /// Low bits that a weight loses before it is squared, so that the square fits a word.
    WALK_SQUARE_BITS: u32 = 15;
    /// Flights of a photon, at most: it is lost then.
    WALK_FLIGHTS: u32 = 1_000_000;
    /// Distance, in a scene of unit extent, by which rounding may put a photon on the wrong side of a surface.
    WALK_MARGIN: f32 = 1.0 / 1_048_576.0;
    /// Cells along a side of the grid of distances to the surface.
    CLEARANCE_SIDE: u32 = 48;
    /// Collisions in a row that need no look at the surface, at most.
    WALK_FREE: u32 = 4;
    /// Tries at a direction of light from all around, each of which Fresnel's transmittance may reject.
    WALK_TRIES: u32 = 16;
    /// Triangles of a block whose light is summed by one invocation.
    ENTRY_BLOCK: u32 = 256;
    /// Coefficients of the natural logarithm of 1 + t beyond t - t^2 / 2, from that of t^3: Cephes, for m from 0.7 to
    /// 1.4.
    LOGARITHM: [f32; 9] = [
        0.333_333_3, -0.249_999_94, 0.200_007_14, -0.166_680_57, 0.142_493_23, -0.124_201_41, 0.116_769_984,
        -0.115_146_1, 0.070_376_836,
    ];

    /// Vectors of a Krylov space beyond the first one, at most.
    MOST_STEPS: usize = 30;
    /// The gain of the operator of diffusion for even light at which clusters are as exact as the tolerance says.
    GAIN_OF_ONE: f32 = 0.75;
    /// With a smaller gain clusters are more exact, at most by this factor; with a larger one they are never less,
    /// since light of both signs has no share in the gain.
    LEAST_GAIN: f32 = 1e-3;
    /// A triangle is elongated where the square of its longest edge is more than this many times twice its area.
    ELONGATED: f32 = 20.0;
    /// The edges of such a triangle are integrated in parts of at most this width in asinh(t / S).
    PART_WIDTH: f32 = 2.0;
    /// In `small_system`: the operator, column by column of MOST_STEPS + 1, made triangular by rotations.
    SMALL_MATRIX: usize = 0;
    /// Cosines of the rotations.
    SMALL_COSINES: usize = 930;
    /// Sines of the rotations.
    SMALL_SINES: usize = 960;
    /// The right-hand side, rotated.
    SMALL_RIGHT: usize = 990;
    /// The solution's coefficients.
    SMALL_COEFFICIENTS: usize = 1021;
    /// Products of the newest vector with all vectors of the basis, and with itself.
    SMALL_PRODUCTS: usize = 1051;
    /// Norms: of the source term, and of what is left.
    SMALL_NORMS: usize = 1083;
    /// The residual's coefficients, of all vectors.
    SMALL_RESIDUAL: usize = 1085;
    /// The estimate of a solution's error: twice what is left at the triangle, plus this many times the mean left,
    RESIDUAL_SPREAD: f32 = 4.0;
    /// plus this share of `link_error` of the solution there, and of the source term's mean.
    CLUSTER_SHARE: f32 = 0.12;

    /// Layers that a texel of a depth map holds.
    MAP_LAYERS: usize = 4;
    /// Steps along a view ray in which light scatters once; their ends are at squares of equal parts.
    SINGLE_STEPS: u32 = 16;
    /// Distance, in a scene of unit extent, by which rounding may put a point of such a ray outside the object.
    SINGLE_MARGIN: f32 = 1.0 / 1_048_576.0;
    /// Layers of an object at most.
    MOST_LAYERS: usize = 16;
    /// The least cosine between the fitted plane's normal and the view ray.
    GRAZING: f64 = 0.05;
    /// A sample of the left rule at an interface counts as above it in spite of rounding: its depth counts times this.
    ABOVE_INTERFACE: f64 = 0.99999;
    /// Cosine of light below which less and less enters through a plane, down to nothing from behind it.
    FADING: f64 = 0.01;
    /// The least cosine between a plane and the light.
    LEAST_COSINE: f64 = 1e-6;
}
