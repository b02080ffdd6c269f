//! Tables 3, 4 and 5 as printed by Mertens et al. 2003. Times in milliseconds on two Xeons of 2.4 GHz.

/// A row of table 3: marble, a butterfly subdivision model, 2.5 cm.
pub struct Complexity {
    /// Triangles.
    pub faces: usize,
    /// Links, thousands.
    pub kilolinks: f64,
    /// Time of a frame on the fly, incrementally, and in render mode.
    pub ms: [f64; 3],
}

/// Table 3.
pub const TABLE_3: [Complexity; 4] = [
    Complexity { faces: 2016, kilolinks: 89.0, ms: [20.0, 8.0, 5.0] },
    Complexity { faces: 8160, kilolinks: 388.0, ms: [47.0, 23.0, 13.0] },
    Complexity { faces: 32_736, kilolinks: 1744.0, ms: [188.0, 68.0, 43.0] },
    Complexity { faces: 131_736, kilolinks: 6905.0, ms: [722.0, 351.0, 199.0] },
];

/// Largest extent of table 3's model, millimetres.
pub const EXTENT_3: f64 = 25.0;

/// A row of table 4: marble, 10 cm, "very conservative thresholds".
pub struct Model {
    /// Its name.
    pub name: &'static str,
    /// Kind of hierarchy: face clusters (FC), or subdivision (S).
    pub hierarchy: &'static str,
    /// Triangles.
    pub faces: usize,
    /// Links, thousands.
    pub kilolinks: f64,
    /// Time of a frame on the fly.
    pub ms: f64,
    /// Our shape that stands in, as in `object.0.shape`.
    pub stand_in: &'static str,
}

/// Table 4.
pub const TABLE_4: [Model; 5] = [
    Model { name: "horse", hierarchy: "FC", faces: 8764, kilolinks: 992.0, ms: 97.0, stand_in: "lotus" },
    Model { name: "bust", hierarchy: "FC", faces: 10_518, kilolinks: 1258.0, ms: 102.0, stand_in: "slab" },
    Model { name: "elk", hierarchy: "FC", faces: 11_384, kilolinks: 1743.0, ms: 165.0, stand_in: "lotus" },
    Model { name: "candle", hierarchy: "S", faces: 4474, kilolinks: 435.0, ms: 41.0, stand_in: "sphere" },
    Model { name: "cube", hierarchy: "S", faces: 16_380, kilolinks: 1572.0, ms: 154.0, stand_in: "slab" },
];

/// Largest extent of table 4's models, millimetres.
pub const EXTENT_4: f64 = 100.0;

/// A row of table 5: marble, on the fly; the paper does not name the model.
pub struct Scale {
    /// Largest extent, metres.
    pub meters: f64,
    /// Time of a frame with the paper's form factor, and with point samples.
    pub ms: [f64; 2],
}

/// Table 5.
pub const TABLE_5: [Scale; 5] = [
    Scale { meters: 0.05, ms: [160.0, 162.0] },
    Scale { meters: 0.1, ms: [160.0, 168.0] },
    Scale { meters: 0.2, ms: [161.0, 222.0] },
    Scale { meters: 0.4, ms: [169.0, 501.0] },
    Scale { meters: 0.8, ms: [340.0, 1778.0] },
];

/// The extent in figure 5, metres: one row of table 5.
pub const FIGURE_5: f64 = 0.2;
