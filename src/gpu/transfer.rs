//! Copies between host and device: in place where the host sees the memory, else many ranges of buffers in one
//! submission, through a staging buffer.

use std::ops::Range;
use std::ptr::NonNull;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::call::vk_call;
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use crate::error::{Error, Result};

/// Most bytes that go through staging in one submission.
const STAGING: u64 = 32 << 20;

/// Bytes to copy to a buffer.
#[derive(Clone, Copy)]
pub struct Upload<'a> {
    /// The buffer.
    pub buffer: &'a Buffer,
    /// The first byte of it that is overwritten.
    pub offset: u64,
    /// The bytes.
    pub bytes: &'a [u8],
}

/// Bytes of a buffer.
#[derive(Clone, Copy)]
pub struct BufferRange<'a> {
    /// The buffer.
    pub buffer: &'a Buffer,
    /// The first byte.
    pub offset: u64,
    /// How many bytes.
    pub size: u64,
}

/// Bytes that a download has brought: a range, or a part of one.
pub struct Downloaded<'a> {
    /// The index of the range.
    pub range: usize,
    /// The first byte within the range.
    pub offset: usize,
    /// The bytes.
    pub bytes: &'a [u8],
}

/// A part of a range, and where it lies in the staging buffer.
struct Piece {
    /// The index of the range.
    range: usize,
    /// Its first byte within the range.
    offset: u64,
    /// Its first byte within the staging buffer.
    staged_at: u64,
    size: u64,
}

impl Piece {
    fn staged(&self) -> Range<usize> {
        self.staged_at as usize..(self.staged_at + self.size) as usize
    }

    fn within(&self) -> Range<usize> {
        self.offset as usize..(self.offset + self.size) as usize
    }
}

/// Ranges of these sizes, cut and gathered into submissions of at most [`STAGING`] bytes.
fn batches(sizes: impl Iterator<Item = u64>) -> Vec<Vec<Piece>> {
    let mut batches: Vec<Vec<Piece>> = Vec::new();
    let mut used = STAGING;
    for (range, whole) in sizes.enumerate() {
        let mut offset = 0;
        while offset < whole {
            if used == STAGING {
                batches.push(Vec::new());
                used = 0;
            }
            let size = (whole - offset).min(STAGING - used);
            let batch = batches.len() - 1;
            batches[batch].push(Piece { range, offset, staged_at: used, size });
            offset += size;
            // Copies are fastest at multiples of 16 bytes.
            used = (used + size).next_multiple_of(16).min(STAGING);
        }
    }
    batches
}

/// A staging buffer as large as the largest of these submissions needs.
fn staging(device: &LogicalDevice, batches: &[Vec<Piece>], location: MemoryLocation) -> Result<Buffer> {
    let ends = batches.iter().filter_map(|batch| batch.last()).map(|piece| piece.staged_at + piece.size);
    Buffer::in_memory(device, "staging", ends.max().unwrap_or(0), location)
}

/// What is being done to these buffers, for errors; fails where a range ends beyond its buffer.
fn checked(verb: &str, ranges: &[BufferRange<'_>]) -> Result<String> {
    let mut names = ranges.iter().filter(|range| range.size > 0).map(|range| range.buffer.name());
    let first = names.next().unwrap_or_default();
    let doing = match names.count() {
        0 => format!("{verb} buffer {first}"),
        more => format!("{verb} buffer {first} and {more} more"),
    };
    for BufferRange { buffer, offset, size } in ranges {
        if offset.saturating_add(*size) > buffer.size() {
            let what = format!("{size} bytes from {offset} on are beyond the {} of {}", buffer.size(), buffer.name());
            return Err(Error::device(doing, what));
        }
    }
    Ok(doing)
}

/// Copies bytes to buffers.
pub fn upload(device: &LogicalDevice, uploads: &[Upload<'_>]) -> Result<()> {
    let ranges: Vec<_> = uploads
        .iter()
        .map(|&Upload { buffer, offset, bytes }| BufferRange { buffer, offset, size: bytes.len() as u64 })
        .collect();
    let doing = checked("filling", &ranges)?;
    device.ready(&doing)?;
    for Upload { buffer, offset, bytes } in uploads {
        if let Some(place) = buffer.in_place(false) {
            // SAFETY: the range lies in the buffer, whose memory is mapped; no submission is running.
            unsafe { place.add(*offset as usize).copy_from_nonoverlapping(NonNull::from(*bytes).cast(), bytes.len()) };
        }
    }
    let copied = |range: &BufferRange<'_>| if range.buffer.in_place(false).is_some() { 0 } else { range.size };
    let batches = batches(ranges.iter().map(copied));
    if batches.is_empty() {
        return Ok(());
    }
    let mut staging = staging(device, &batches, MemoryLocation::CpuToGpu)?;
    for batch in &batches {
        let mapped = staging.mapped(&doing)?;
        for piece in batch {
            mapped[piece.staged()].copy_from_slice(&uploads[piece.range].bytes[piece.within()]);
        }
        let copies = batch.iter().map(|piece| {
            let Upload { buffer, offset, .. } = uploads[piece.range];
            let from = BufferRange { buffer: &staging, offset: piece.staged_at, size: piece.size };
            Copy { from, to: buffer, to_offset: offset + piece.offset }
        });
        copy(device, copies, &doing)?;
    }
    Ok(())
}

/// Copies ranges of buffers to the host; `take` is given the bytes of each, which may come in parts.
pub fn download(
    device: &LogicalDevice,
    ranges: &[BufferRange<'_>],
    mut take: impl FnMut(Downloaded<'_>),
) -> Result<()> {
    let doing = checked("reading", ranges)?;
    device.ready(&doing)?;
    for (at, &BufferRange { buffer, offset, size }) in ranges.iter().enumerate() {
        if let Some(place) = buffer.in_place(true) {
            // SAFETY: the range lies in the buffer, whose memory is mapped; no submission is running, and the barrier
            // at its end makes what it wrote visible to the host.
            let bytes = unsafe { std::slice::from_raw_parts(place.as_ptr().add(offset as usize), size as usize) };
            take(Downloaded { range: at, offset: 0, bytes });
        }
    }
    let copied = |range: &BufferRange<'_>| if range.buffer.in_place(true).is_some() { 0 } else { range.size };
    let batches = batches(ranges.iter().map(copied));
    if batches.is_empty() {
        return Ok(());
    }
    let mut staging = staging(device, &batches, MemoryLocation::GpuToCpu)?;
    for batch in &batches {
        let copies = batch.iter().map(|piece| {
            let BufferRange { buffer, offset, .. } = ranges[piece.range];
            let from = BufferRange { buffer, offset: offset + piece.offset, size: piece.size };
            Copy { from, to: &staging, to_offset: piece.staged_at }
        });
        copy(device, copies, &doing)?;
        let mapped = staging.mapped(&doing)?;
        for piece in batch {
            let bytes = &mapped[piece.staged()];
            take(Downloaded { range: piece.range, offset: piece.offset as usize, bytes });
        }
    }
    Ok(())
}

impl Buffer {
    /// Copies `bytes` to the start of the buffer.
    pub fn upload(&self, bytes: &[u8]) -> Result<()> {
        upload(&self.device, &[Upload { buffer: self, offset: 0, bytes }])
    }

    /// Copies the start of the buffer to `bytes`.
    pub fn download(&self, bytes: &mut [u8]) -> Result<()> {
        let range = BufferRange { buffer: self, offset: 0, size: bytes.len() as u64 };
        download(&self.device, &[range], |part| {
            bytes[part.offset..part.offset + part.bytes.len()].copy_from_slice(part.bytes);
        })
    }
}

/// A copy from a range of a buffer to another buffer.
struct Copy<'a> {
    from: BufferRange<'a>,
    to: &'a Buffer,
    /// The first byte of `to` that is overwritten.
    to_offset: u64,
}

/// Copies on the device's queue, and waits for the end of it.
fn copy<'a>(device: &LogicalDevice, copies: impl Iterator<Item = Copy<'a>>, doing: &str) -> Result<()> {
    let commands = device.begin(doing)?;
    // The host reads what was copied, and so do kernels, indirect dispatches and copies that are submitted later.
    let seen = vk::AccessFlags::HOST_READ
        | vk::AccessFlags::SHADER_READ
        | vk::AccessFlags::SHADER_WRITE
        | vk::AccessFlags::UNIFORM_READ
        | vk::AccessFlags::INDIRECT_COMMAND_READ
        | vk::AccessFlags::TRANSFER_READ
        | vk::AccessFlags::TRANSFER_WRITE;
    let after = vk::PipelineStageFlags::HOST
        | vk::PipelineStageFlags::COMPUTE_SHADER
        | vk::PipelineStageFlags::DRAW_INDIRECT
        | vk::PipelineStageFlags::TRANSFER;
    let visible = [vk::MemoryBarrier::default().src_access_mask(vk::AccessFlags::TRANSFER_WRITE).dst_access_mask(seen)];
    // SAFETY: all buffers live through the submission; the callers have checked the ranges; the wait ends all use.
    unsafe {
        let raw = device.raw();
        for Copy { from, to, to_offset } in copies {
            let region = [vk::BufferCopy { src_offset: from.offset, dst_offset: to_offset, size: from.size }];
            raw.cmd_copy_buffer(commands, from.buffer.raw, to.raw, &region);
        }
        raw.cmd_pipeline_barrier(
            commands,
            vk::PipelineStageFlags::TRANSFER,
            after,
            vk::DependencyFlags::empty(),
            &visible,
            &[],
            &[],
        );
        let done = vk_call("vkEndCommandBuffer", doing, || raw.end_command_buffer(commands))
            .and_then(|()| device.submit(commands, doing));
        device.discard(commands);
        done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_copied_once_in_submissions_of_bounded_size() {
        let sizes = [0, 1, STAGING - 20, 5, 0, 3 * STAGING + 7, 4, 64];
        let batches = batches(sizes.iter().copied());
        let mut next = [0; 8];
        for batch in &batches {
            let mut used = 0;
            for piece in batch {
                assert!(piece.size > 0 && piece.staged_at >= used && piece.staged_at + piece.size <= STAGING);
                assert_eq!(piece.offset, next[piece.range]);
                next[piece.range] += piece.size;
                used = piece.staged_at + piece.size;
            }
        }
        assert_eq!(next, sizes);
        assert_eq!(batches.len(), 5);
    }
}
