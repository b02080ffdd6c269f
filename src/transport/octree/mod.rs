//! The baseline: the irradiance octree of Jensen and Buhler 2002, "A Rapid Hierarchical Rendering Technique for
//! Translucent Materials", in `f32` and optimised for CPUs.
//!
//! Every cell stores the power of its samples, their mean position weighted by power, and their area. A cell stands
//! for its samples where its solid angle `area / d^2` is below a threshold and the receiver is outside its box;
//! otherwise it is opened. Each source adds `E A R_d(d)`, with the dipole's distance measured from the point where
//! light enters.
//!
//! The optimisations change none of this:
//! - 16 neighbouring receivers walk the tree together (`traverse`); a cell is opened for all where one of them, or
//!   the nearest point of their common box, needs it open. So no receiver gets less accuracy than it asks for.
//! - The up to eight children of a cell lie side by side and are judged at once.
//! - The walk lists the sources that it accepts; they are evaluated afterwards for the 16 receivers at once (`direct`),
//!   or, with AVX-512, by a table whose rows fit two registers (`table`).
//! - Unlit cells and samples are not in the tree; only their area counts.

mod build;
mod direct;
mod packets;
#[cfg(target_arch = "x86_64")]
mod table;
#[cfg(test)]
mod tests;
mod traverse;

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

use self::direct::Channel;
use self::packets::{LANES, Point};
use crate::dipole::profile::Dipole;
use crate::layout::BufferId;
use crate::state::{Carrier, Host};

/// The octree's place in the frame: not a stage, because it always runs on the host, in native code.
pub static HOST: Host = Host {
    name: "octree",
    about: "irradiance octree over the faces' centroids, in native code on the host",
    equation: "Jensen and Buhler 2002",
    reads: BufferId::irradiance,
    writes: BufferId::radiosity,
    carrier: Carrier::Octree,
};

/// Sources summed in one go before their sum joins the total: this limits the rounding of long lists.
const RUN: usize = 512;

/// A point where light enters: one per face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The face's centroid, length.
    pub position: [f32; 3],
    /// The face's area, length^2, at least 0.
    pub area: f32,
    /// Irradiance E of each channel after Fresnel, at least 0.
    pub irradiance: [f32; 3],
}

/// An emitter: a cell or a single sample.
#[derive(Clone, Copy, Debug, Default)]
struct Source {
    place: [f32; 3],
    /// Area times irradiance, of each channel.
    power: [f32; 3],
}

/// A node's children in the tree: cells, or the samples of a leaf.
#[derive(Clone, Copy, Debug)]
struct Children {
    /// Index among the sources: less than the number of nodes if they are cells.
    first: u32,
    count: u32,
}

/// Samples in an octree, with the sums of every cell. Nodes lie breadth first, siblings side by side.
#[derive(Clone, Debug, Default)]
pub struct Octree {
    /// The sources of the nodes, then those of the lit samples.
    sources: Vec<Source>,
    /// The nodes' positions again, by axis, with padding at the end.
    places: [Vec<f32>; 3],
    /// The nodes' areas, with padding; 0 for a single sample.
    areas: Vec<f32>,
    /// Squared distance from a node's position to the farthest corner of its box, with padding; 0 for a single sample.
    reaches: Vec<f32>,
    /// The boxes around the nodes' samples: low and high corner.
    boxes: Vec<[[f32; 3]; 2]>,
    children: Vec<Children>,
}

/// The profile in the form the processor evaluates fastest.
struct Profile {
    channels: [Channel; 3],
    #[cfg(target_arch = "x86_64")]
    table: Option<Box<table::Table>>,
}

impl Octree {
    /// Builds the tree over the lit ones of `samples`.
    #[must_use]
    pub fn new(samples: &[Sample]) -> Self {
        build::build(samples)
    }

    /// Radiosity of each channel at each of `receivers`.
    ///
    /// `dipoles`: the profile of each channel, in the unit of the samples. `threshold`: the solid angle, in
    /// steradians, above which a cell is opened; 0 sums every sample. The result has the same bits for any number of
    /// threads.
    #[must_use]
    pub fn gather(&self, dipoles: &[Dipole; 3], threshold: f32, receivers: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.gather_at(Level::new(), dipoles, threshold, receivers)
    }

    fn gather_at(&self, level: Level, dipoles: &[Dipole; 3], threshold: f32, receivers: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut radiosity = vec![[0.0; 3]; receivers.len()];
        if self.children.is_empty() || receivers.is_empty() {
            return radiosity;
        }
        let profile = Profile::new(level, dipoles, self.farthest2(receivers));
        let points = packets::sort(receivers);
        let sums: Vec<[[f32; LANES]; 3]> = points
            .par_chunks(LANES)
            .with_min_len(8)
            .map_init(
                traverse::Walk::default,
                |walk, packet| dispatch!(level, simd => self.packet(simd, &profile, threshold, packet, walk)),
            )
            .collect();
        for (packet, sum) in points.chunks(LANES).zip(&sums) {
            for (lane, point) in packet.iter().enumerate() {
                radiosity[point.index as usize] = sum.map(|channel| channel[lane]);
            }
        }
        radiosity
    }

    /// Squared diagonal of the box around all sources and receivers: no receiver is farther from any source.
    fn farthest2(&self, receivers: &[[f32; 3]]) -> f64 {
        let [low, high] = receivers.iter().fold(self.boxes[0], |[low, high], p| {
            [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
        });
        (0..3).map(|k| (f64::from(high[k]) - f64::from(low[k])).powi(2)).sum()
    }

    #[inline(always)]
    fn packet<S: Simd>(
        &self,
        simd: S,
        profile: &Profile,
        threshold: f32,
        packet: &[Point],
        walk: &mut traverse::Walk,
    ) -> [[f32; LANES]; 3] {
        // Unused lanes repeat the last receiver.
        let mut at = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let point = packet[lane.min(packet.len() - 1)].at;
            for k in 0..3 {
                at[k][lane] = point[k];
            }
        }
        self.walk(simd, threshold, packets::bounds(packet), walk);

        #[cfg(target_arch = "x86_64")]
        if let (Some(table), Level::Avx512(avx512)) = (&profile.table, simd.level()) {
            let mut sum = [[0.0; LANES]; 3];
            for run in walk.list.chunks(RUN) {
                table::evaluate(avx512, table, &self.sources, run, &at, &mut sum);
            }
            return sum;
        }
        let at = [f32x16::simd_from(simd, at[0]), f32x16::simd_from(simd, at[1]), f32x16::simd_from(simd, at[2])];
        let mut sum = [f32x16::splat(simd, 0.0); 3];
        for run in walk.list.chunks(RUN) {
            direct::evaluate(simd, &profile.channels, &self.sources, run, &at, &mut sum);
        }
        sum.map(Into::into)
    }
}

impl Profile {
    /// The profile, with a table only where it can be used.
    #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables, reason = "only AVX-512 has use for a table"))]
    fn new(level: Level, dipoles: &[Dipole; 3], farthest2: f64) -> Self {
        Self {
            channels: [Channel::new(&dipoles[0]), Channel::new(&dipoles[1]), Channel::new(&dipoles[2])],
            #[cfg(target_arch = "x86_64")]
            table: level.as_avx512().and_then(|_| table::Table::new(dipoles, farthest2)).map(Box::new),
        }
    }
}
