//! Packets of 16 receivers that lie close together, by median cuts across the longest side at multiples of 16.
//!
//! Measured against packets of consecutive receivers along a Morton curve, whose jumps make large boxes: 10 to 20 %
//! fewer sources per packet at equal threshold, and every packet but the last is full.

/// Receivers per packet: the lanes of the widest registers.
pub const LANES: usize = 16;

/// Fewest receivers that are worth another thread.
const PARALLEL: usize = 4096;

/// A receiver.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Its position.
    pub at: [f32; 3],
    /// Its index in the caller's list.
    pub index: u32,
}

/// Sorts the receivers so that every [`LANES`] of them form a packet.
pub fn sort(receivers: &[[f32; 3]]) -> Vec<Point> {
    let mut points: Vec<Point> =
        receivers.iter().enumerate().map(|(index, &at)| Point { at, index: index as u32 }).collect();
    cut(&mut points);
    points
}

/// The box around some points: low and high corner.
pub fn bounds(points: &[Point]) -> [[f32; 3]; 2] {
    points.iter().fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[low, high], Point { at, .. }| {
        [std::array::from_fn(|k| low[k].min(at[k])), std::array::from_fn(|k| high[k].max(at[k]))]
    })
}

fn cut(points: &mut [Point]) {
    if points.len() <= LANES {
        return;
    }
    let [low, high] = bounds(points);
    let extent = |k: usize| high[k] - low[k];
    let axis = (1..3).fold(0, |best, k| if extent(k) > extent(best) { k } else { best });
    let middle = points.len().div_ceil(LANES) / 2 * LANES;
    points.select_nth_unstable_by(middle, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.index.cmp(&b.index)));
    let (left, right) = points.split_at_mut(middle);
    if left.len() < PARALLEL {
        cut(left);
        cut(right);
    } else {
        rayon::join(|| cut(left), || cut(right));
    }
}
