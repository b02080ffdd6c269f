//! Levels of detail of the built-in shapes.

use super::Shape;
use std::ops::RangeInclusive;

impl Shape {
    /// The levels of detail that the shape accepts.
    pub fn details(self) -> RangeInclusive<u32> {
        match self {
            Self::Sphere => 0..=8,
            Self::Slab => 1..=512,
            Self::Lotus => 16..=2048,
            Self::Plane | Self::Bump => 1..=512,
            Self::Cube => 1..=256,
            Self::Torus => 3..=1024,
            Self::Candle => 16..=1024,
            Self::Bust => 64..=192,
            Self::Fish | Self::Gecko => 1..=8,
        }
    }

    /// The default detail.
    pub fn usual_detail(self) -> u32 {
        match self {
            Self::Sphere => 5,
            Self::Slab => 32,
            Self::Lotus => 256,
            Self::Plane => 32,
            Self::Cube => 48,
            Self::Torus => 160,
            Self::Bump => 128,
            Self::Candle => 192,
            Self::Bust => 128,
            Self::Fish | Self::Gecko => 1,
        }
    }

    /// An upper bound on the number of triangles of the shape, at most about twice that number.
    pub fn most_triangles(self, detail: u32) -> u64 {
        let n = u64::from(detail);
        match self {
            Self::Sphere => 20 << (2 * n.min(16)),
            Self::Slab => 4 * n * n + 8 * n * (n / 5).max(1),
            Self::Lotus => n * n + 32 * n,
            Self::Plane => 2 * n * n,
            Self::Cube => 12 * n * n + 200 * n + 600,
            Self::Torus => n * n + 4 * n,
            Self::Bump => 6 * n * n + 200 * n + 600,
            Self::Candle => 2 * n * n + 40 * n,
            Self::Bust => 4 * n * n,
            Self::Fish => 2788 * n * n,
            Self::Gecko => 10_944 * n * n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn no_shape_has_more_triangles_than_it_says() {
        use Shape::*;
        for shape in [Sphere, Slab, Lotus, Plane, Cube, Torus, Bump, Candle, Bust, Fish, Gecko] {
            let least = *shape.details().start();
            for detail in [least, least + 1, (2 * least + 1).min(*shape.details().end())] {
                let (most, count) = (shape.most_triangles(detail), shape.build(detail).triangles.len() as u64);
                assert!(count <= most && (most <= 2 * count + 1000), "{shape:?} {detail}: {count}, {most}");
            }
        }
    }
}
