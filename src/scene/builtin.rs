//! The built-in scenes.

/// The built-in scenes: name, TOML text, and one line about it.
pub const BUILTIN: &[(&str, &str, &str)] = &[
    (
        "bump",
        include_str!("builtin/bump.toml"),
        "a slab of stone with a bump, whose shadow light leaks into; another one moves over 60 frames",
    ),
    ("bust", include_str!("builtin/bust.toml"), "a marble bust under the sky"),
    ("candle", include_str!("builtin/candle.toml"), "a candle on a table, lit by its flame"),
    ("fish", include_str!("builtin/fish.toml"), "a fish whose ribs and belly show through its skin"),
    ("gecko", include_str!("builtin/gecko.toml"), "a gecko in a thin bumpy skin"),
    ("lotus", include_str!("builtin/lotus.toml"), "a bowl of petals with a candle in it"),
    ("noise", include_str!("builtin/noise.toml"), "a cube of skim milk, moved by wandering noise over 60 frames"),
    ("slab", include_str!("builtin/slab.toml"), "a slab of skim milk, a lamp close behind it"),
    (
        "slab-layers",
        include_str!("builtin/slab-layers.toml"),
        "a slab of three even layers, in which light scatters once",
    ),
    ("sphere", include_str!("builtin/sphere.toml"), "a marble ball in the sun"),
    ("torus", include_str!("builtin/torus.toml"), "a ring of jade, bent to and fro over 60 frames"),
    ("twist", include_str!("builtin/twist.toml"), "a slab of wax, wrung like a cloth over 60 frames"),
    ("veins", include_str!("builtin/veins.toml"), "a bust of skin with veins under it"),
];
