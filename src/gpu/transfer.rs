//! Copies between host and device: many ranges of buffers in one submission, through a staging buffer.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::device::Device;
use super::faults::tried;
use super::memory::Buffer;
use crate::error::{Error, Result};

/// Most bytes that go through staging in one submission.
const STAGING: u64 = 32 << 20;

/// Part of a range, and where it lies in the staging buffer.
struct Piece {
    range: usize,
    from: u64,
    at: u64,
    size: u64,
}

impl Piece {
    fn staged(&self) -> std::ops::Range<usize> {
        self.at as usize..(self.at + self.size) as usize
    }

    fn within(&self) -> std::ops::Range<usize> {
        self.from as usize..(self.from + self.size) as usize
    }
}

/// Ranges of these sizes, cut and gathered into submissions of at most [`STAGING`] bytes.
fn batches(sizes: impl Iterator<Item = u64>) -> Vec<Vec<Piece>> {
    let mut batches: Vec<Vec<Piece>> = Vec::new();
    let mut used = STAGING;
    for (range, whole) in sizes.enumerate() {
        let mut from = 0;
        while from < whole {
            if used == STAGING {
                batches.push(Vec::new());
                used = 0;
            }
            let size = (whole - from).min(STAGING - used);
            let batch = batches.len() - 1;
            batches[batch].push(Piece { range, from, at: used, size });
            from += size;
            // Multiples of 16, which is as fast as copies get.
            used = (used + size).next_multiple_of(16).min(STAGING);
        }
    }
    batches
}

/// The staging buffer that the largest of these submissions asks for.
fn staging(device: &Device, batches: &[Vec<Piece>], location: MemoryLocation) -> Result<Buffer> {
    let ends = batches.iter().filter_map(|batch| batch.last()).map(|piece| piece.at + piece.size);
    Buffer::at(device, "staging", ends.max().unwrap_or(0), location)
}

/// What is being done to these buffers, for errors; fails where a range ends beyond its buffer.
fn checked<'a>(verb: &str, ranges: impl Iterator<Item = (&'a Buffer, u64, u64)> + Clone) -> Result<String> {
    let mut names = ranges.clone().filter(|(_, _, size)| *size > 0).map(|(buffer, _, _)| buffer.name());
    let first = names.next().unwrap_or_default();
    let doing = match names.count() {
        0 => format!("{verb} buffer {first}"),
        more => format!("{verb} buffer {first} and {more} more"),
    };
    for (buffer, from, size) in ranges {
        if from.saturating_add(size) > buffer.size() {
            let what = format!("{size} bytes from {from} on are beyond the {} of {}", buffer.size(), buffer.name());
            return Err(Error::device(doing, what));
        }
    }
    Ok(doing)
}

/// Copies bytes to each of these buffers, from a byte of it on.
pub fn upload(device: &Device, ranges: &[(&Buffer, u64, &[u8])]) -> Result<()> {
    let doing = checked("filling", ranges.iter().map(|(buffer, from, bytes)| (*buffer, *from, bytes.len() as u64)))?;
    let batches = batches(ranges.iter().map(|(_, _, bytes)| bytes.len() as u64));
    if batches.is_empty() {
        return Ok(());
    }
    let mut staging = staging(device, &batches, MemoryLocation::CpuToGpu)?;
    for batch in &batches {
        let mapped = staging.mapped(&doing)?;
        for piece in batch {
            mapped[piece.staged()].copy_from_slice(&ranges[piece.range].2[piece.within()]);
        }
        let copies = batch.iter().map(|piece| {
            let (buffer, from, _) = ranges[piece.range];
            ((&staging, piece.at), (buffer, from + piece.from), piece.size)
        });
        copy(device, copies, &doing)?;
    }
    Ok(())
}

/// Copies a number of bytes of each of these buffers, from a byte of it on; `take` is told the range, the first byte within it, and
/// the bytes, which may come in parts.
pub fn download(
    device: &Device,
    ranges: &[(&Buffer, u64, u64)],
    mut take: impl FnMut(usize, usize, &[u8]),
) -> Result<()> {
    let doing = checked("reading", ranges.iter().copied())?;
    let batches = batches(ranges.iter().map(|(_, _, size)| *size));
    if batches.is_empty() {
        return Ok(());
    }
    let mut staging = staging(device, &batches, MemoryLocation::GpuToCpu)?;
    for batch in &batches {
        let copies = batch.iter().map(|piece| {
            let (buffer, from, _) = ranges[piece.range];
            ((buffer, from + piece.from), (&staging, piece.at), piece.size)
        });
        copy(device, copies, &doing)?;
        let mapped = staging.mapped(&doing)?;
        for piece in batch {
            take(piece.range, piece.from as usize, &mapped[piece.staged()]);
        }
    }
    Ok(())
}

/// Copies on the queue, waited for: from a byte of a buffer, to a byte of another, so many bytes.
fn copy<'a>(
    device: &Device,
    copies: impl Iterator<Item = ((&'a Buffer, u64), (&'a Buffer, u64), u64)>,
    doing: &str,
) -> Result<()> {
    let commands = device.begin(doing)?;
    let visible = [vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
        .dst_access_mask(vk::AccessFlags::HOST_READ)];
    // SAFETY: all buffers live through the submission; ranges were checked by the callers; the wait ends all use.
    unsafe {
        let raw = &device.0.raw;
        for (from, to, size) in copies {
            let region = [vk::BufferCopy { src_offset: from.1, dst_offset: to.1, size }];
            raw.cmd_copy_buffer(commands, from.0.raw, to.0.raw, &region);
        }
        raw.cmd_pipeline_barrier(
            commands,
            vk::PipelineStageFlags::TRANSFER,
            vk::PipelineStageFlags::HOST,
            vk::DependencyFlags::empty(),
            &visible,
            &[],
            &[],
        );
        let done = tried("vkEndCommandBuffer", doing, || raw.end_command_buffer(commands))
            .and_then(|()| device.submit(commands, doing));
        device.discard(commands);
        done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_travels_once_in_submissions_of_bounded_size() {
        let sizes = [0, 1, STAGING - 20, 5, 0, 3 * STAGING + 7, 4, 64];
        let batches = batches(sizes.iter().copied());
        let mut next = [0; 8];
        for batch in &batches {
            let mut used = 0;
            for piece in batch {
                assert!(piece.size > 0 && piece.at >= used && piece.at + piece.size <= STAGING);
                assert_eq!(piece.from, next[piece.range]);
                next[piece.range] += piece.size;
                used = piece.at + piece.size;
            }
        }
        assert_eq!(next, sizes);
        assert_eq!(batches.len(), 5);
    }
}
