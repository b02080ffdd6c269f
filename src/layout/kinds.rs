//! What the values of a field, a decision or a specialization constant mean. A prefix says which of them it is.

use super::{Constant, Shared};

constants! {
    /// Every such value, in groups of one prefix; some Rust file or shader uses each group.
    kinds:

    /// `Light.kind`: from one direction.
    LIGHT_DIRECTIONAL: u32 = 0;
    /// From a point, alike in all directions.
    LIGHT_POINT: u32 = 1;
    /// From a point, within a cone.
    LIGHT_SPOT: u32 = 2;
    /// A sample of an area that shines to one side.
    LIGHT_AREA: u32 = 3;
    /// A sample of an area that shines to both sides.
    LIGHT_AREA_BOTH: u32 = 4;
    /// A ray to the environment.
    LIGHT_SKY_RAY: u32 = 5;
    /// A ray to the environment, drawn from the lobe in which a surface reflects what the eye sees.
    LIGHT_MIRROR_RAY: u32 = 6;
    /// The same, drawn from where the environment is bright.
    LIGHT_BRIGHT_RAY: u32 = 7;

    /// `Deform.kind`: a twist about an axis.
    DEFORM_TWIST: u32 = 1;
    /// A bend.
    DEFORM_BEND: u32 = 2;
    /// A bump along an axis.
    DEFORM_BUMP_AXIS: u32 = 3;
    /// A bump along the normal.
    DEFORM_BUMP_NORMAL: u32 = 4;
    /// Noise along the normal.
    DEFORM_NOISE: u32 = 5;
    /// A morph towards another mesh.
    DEFORM_MORPH: u32 = 6;
    /// The place that joints give, before any other deformation.
    DEFORM_SKIN: u32 = 7;

    /// `ObjectParams.texture_wrap` and `Layering.wrap`: beyond its edges the texture repeats.
    WRAP_REPEAT: u32 = 0;
    /// Its outermost texels go on.
    WRAP_CLAMP: u32 = 1;
    /// It repeats, mirrored.
    WRAP_MIRROR: u32 = 2;

    /// Bits of `ObjectParams.texture_side`: light is multiplied by the texture where it enters.
    TEXTURE_ENTERS: u32 = 1;
    /// Where it leaves.
    TEXTURE_LEAVES: u32 = 2;

    /// `ObjectParams.opaque`: light enters the object.
    OPAQUE_NOT: u32 = 0;
    /// None does, and it is lit triangle by triangle.
    OPAQUE_BY_FACE: u32 = 1;
    /// None does, and it is lit pixel by pixel.
    OPAQUE_BY_PIXEL: u32 = 2;

    /// `ObjectParams.kappa`: sqrt((k1^2 + k2^2) / 2).
    KAPPA_RMS: u32 = 0;
    /// |k1 + k2| / 2.
    KAPPA_MEAN: u32 = 1;

    /// `ObjectParams.reflection`: the surface reflects nothing.
    REFLECTION_NONE: u32 = 0;
    /// It reflects by Phong's lobe.
    REFLECTION_PHONG: u32 = 1;
    /// It reflects by GGX microfacets.
    REFLECTION_GGX: u32 = 2;

    /// How the depths of an object's layers are looked up: they are the same everywhere.
    MAPPED_NOT: u32 = 0;
    /// By texture coordinates.
    MAPPED_BY_UVS: u32 = 1;
    /// By places in maps laid out by islands.
    MAPPED_BY_ISLANDS: u32 = 2;

    /// What becomes of an emitter at a block: its light counts for nothing.
    LINK_DROPPED: u32 = 0;
    /// It is expanded about the block's centre.
    LINK_EXPANDED: u32 = 1;
    /// It is evaluated at each receiver.
    LINK_DIRECT: u32 = 2;
    /// A triangle that takes area points.
    LINK_AREA: u32 = 3;
    /// A triangle that takes the edge form.
    LINK_EDGE: u32 = 4;
    /// Its children are looked at instead.
    LINK_OPENED: u32 = 5;
    /// The number of these.
    LINK_KINDS: usize = 6;

    /// The error laws of `acceptance_radii`: the light itself.
    LAW_MAGNITUDE: usize = 0;
    /// A cluster by its moments.
    LAW_MOMENTS: usize = 1;
    /// An expansion about a block's centre.
    LAW_EXPANSION: usize = 2;
    /// A triangle by one sample.
    LAW_SAMPLE: usize = 3;
    /// A triangle by 6 area points.
    LAW_AREA: usize = 4;

    /// What becomes of an emitter at a receiver of the published method: it is linked.
    PAIR_LINKED: u32 = 1;
    /// It is handed down to the receiver's children.
    PAIR_HANDED: u32 = 2;
    /// Its children are looked at instead.
    PAIR_SPLIT: u32 = 3;

    /// Which refinement has a pair, in two bits below the emitter in `handed`: the one of now.
    PAIR_NOW: u32 = 1;
    /// The one before.
    PAIR_BEFORE: u32 = 2;
    /// Both.
    PAIR_BOTH: u32 = 3;

    /// How a link's form factor is evaluated: by one sample.
    RULE_SAMPLE: u32 = 0;
    /// By area points.
    RULE_AREA: u32 = 1;
    /// By the edge form.
    RULE_EDGE: u32 = 2;

    /// In `due_groups`, after one element a rule: receivers whose links are merged.
    DUE_MERGED: usize = 3;
    /// Receivers whose links are summed again.
    DUE_SUMMED: usize = 4;
    /// Elements of `due_groups`.
    DUE_GROUPS: usize = 5;

    /// Bits of `change_flags`: a triangle of the cluster has moved since links were made.
    ALTERED_MOVED: u32 = 1;
    /// The light that enters a triangle of the cluster is not the one that was summed last.
    ALTERED_RELIT: u32 = 2;
}
