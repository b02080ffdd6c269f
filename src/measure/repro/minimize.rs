//! A smaller case that shows the same failure: fewer groups, and buffers that end where the kernels' reach ends.

use super::{ANY, BITS, Case, Part};
use crate::error::Result;
use crate::gpu::count::{BINDING, touching};
use crate::gpu::{Buffer, Device, interface, shifted};

/// The case without what its failure does not need. Whatever would change the failure on this device stays; so does
/// everything that a case without a failure computes.
pub fn minimize(case: &Case, device: &Device) -> Result<Case> {
    let full = case.run(device)?;
    let mut least = case.clone();
    if case.about.fails && case.dispatches.len() == 1 {
        least = fewer_groups(case, &full, device)?;
    }
    let cut = cut(&least, device)?;
    // What was left out must not matter.
    let (before, after) = (least.run(device)?, cut.run(device)?);
    let same = before.iter().zip(&after).all(|(before, after)| before.starts_with(after));
    let _ = device.take_messages();
    Ok(if same { cut } else { least })
}

/// Whether the device leaves a wrong value where it left the same one in the whole case.
fn shows(case: &Case, full: &[Vec<u32>], left: &[Vec<u32>]) -> bool {
    case.buffers.iter().zip(full.iter().zip(left)).any(|(part, (full, left))| {
        part.wrong(full).any(|word| left[word] == full[word] && full[word] != part.before[word])
    })
}

/// The only dispatch with the groups that fail: the first one that does, or all up to it.
fn fewer_groups(case: &Case, full: &[Vec<u32>], device: &Device) -> Result<Case> {
    let [across, 1, 1] = case.dispatches[0].groups else { return Ok(case.clone()) };
    let found = searched(across, &mut |count, first| {
        let Some(mut less) = grouped(case, count, first) else { return Ok(None) };
        let left = less.run(device)?;
        if !shows(case, full, &left) {
            return Ok(None);
        }
        less.buffers.iter_mut().zip(full.iter().zip(&left)).for_each(|(part, (full, left))| expect(part, full, left));
        Ok(Some(less))
    })?;
    Ok(found.unwrap_or_else(|| case.clone()))
}

/// The only dispatch of a case with `count` of its groups across, from `first` on; none where the kernel's groups can't
/// be renumbered.
pub(super) fn grouped(case: &Case, count: u32, first: u32) -> Option<Case> {
    let mut less = case.clone();
    let dispatch = &mut less.dispatches[0];
    let across = dispatch.groups[0];
    (dispatch.groups, dispatch.first_group) = ([count, 1, 1], dispatch.first_group + first);
    if first > 0 {
        dispatch.spirv = shifted(&dispatch.spirv, first)?;
    }
    less.about.dispatches += &format!(", group {} of {across}", if count == 1 { first + 1 } else { count });
    Some(less)
}

/// The fewest of `across` groups from the first one on with which a fault shows, or the last of those alone. `with`
/// tries a number of groups, from one on, and gives the case if it shows.
pub(super) fn searched(across: u32, with: &mut dyn FnMut(u32, u32) -> Result<Option<Case>>) -> Result<Option<Case>> {
    let (mut none, mut some, mut best) = (0, across, None);
    while none + 1 < some {
        // The first one alone is the likeliest.
        let middle = if none == 0 { 1 } else { none + (some - none) / 2 };
        match with(middle, 0)? {
            Some(less) => (some, best) = (middle, Some(less)),
            None => none = middle,
        }
    }
    let alone = if some > 1 { with(1, some - 1)? } else { None };
    Ok(alone.or(best))
}

/// What to expect of fewer groups: what they leave as all of them did; what they leave untouched stays. A word that
/// should have been written and was not belongs to no known group, so it is not compared.
fn expect(part: &mut Part, full: &[u32], left: &[u32]) {
    let wrong: Vec<usize> = part.wrong(full).filter(|&word| full[word] == part.before[word]).collect();
    for word in 0..left.len() {
        if left[word] != full[word] {
            if left[word] == part.before[word] && part.allowed[word] != ANY {
                (part.expected[word], part.allowed[word]) = (part.before[word], BITS);
            } else {
                part.allowed[word] = ANY;
            }
        }
    }
    wrong.into_iter().for_each(|word| part.allowed[word] = ANY);
    part.device = left.to_vec();
}

/// The case with buffers that end where the reach of the kernels ends, which instrumented kernels note.
fn cut(case: &Case, device: &Device) -> Result<Case> {
    let (mut noting, mut notes, mut more) = (case.clone(), Vec::new(), Vec::new());
    for dispatch in &mut noting.dispatches {
        let Some(found) = touching(&dispatch.kernel, &dispatch.spirv) else { return Ok(case.clone()) };
        dispatch.spirv = found.words;
        let buffer = Buffer::new(device, "notes", 4 * found.notes.len() as u64)?;
        buffer.upload(&vec![0; 4 * found.notes.len()])?;
        notes.push(found.notes);
        more.push((BINDING, buffer));
    }
    noting.run_with(device, &more)?;
    // Whole words of each buffer that some dispatch reaches, or that are wrong.
    let mut reach: Vec<usize> = vec![1; case.buffers.len()];
    for (b, part) in case.buffers.iter().enumerate() {
        reach[b] = part.wrong(&part.device).last().map_or(1, |word| word + 1);
    }
    for ((dispatch, notes), (_, buffer)) in case.dispatches.iter().zip(&notes).zip(&more) {
        let mut counts = vec![0u32; notes.len()];
        buffer.download(bytemuck::cast_slice_mut(&mut counts))?;
        let lengths = interface(&dispatch.kernel, &dispatch.spirv)?.lengths;
        for bound in &dispatch.bindings {
            let note = notes.iter().position(|(number, _)| *number == bound.number);
            let whole = bound.bytes as usize / 4;
            let reached = match note {
                Some(note) if !lengths.contains(&bound.number) => (counts[note] as usize) * notes[note].1 / 4,
                _ => whole,
            };
            reach[bound.buffer] = reach[bound.buffer].max(reached.min(whole));
        }
    }
    let mut less = case.clone();
    for (part, &words) in less.buffers.iter_mut().zip(&reach) {
        for contents in [&mut part.before, &mut part.expected, &mut part.device] {
            contents.truncate(words);
        }
        part.allowed.truncate(words);
    }
    for bound in less.dispatches.iter_mut().flat_map(|dispatch| &mut dispatch.bindings) {
        bound.bytes = bound.bytes.min(4 * reach[bound.buffer] as u64);
    }
    Ok(less)
}
