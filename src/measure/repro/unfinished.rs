//! Cases of dispatches that do not end. A hang, a crash or a lost device leaves no time to write a case afterwards, so
//! each is handed out before it runs.

use super::isolate::drop_unbound;
use super::minimize::{grouped, searched};
use super::trace::{begin, left};
use super::within;
use super::{ANY, BITS, Case};
use crate::error::Result;
use crate::gpu::Device;
use crate::measure::fixtures::Fixture;

/// Runs of all dispatches in one submission, as many as a comparison has.
const RUNS: usize = 2;

/// Runs the step of this index in a fixture: its dispatches one at a time, then all in one submission. `told` gets the
/// case of the next dispatch before it runs, and at the end, if that is reached, the case of the whole step.
pub fn run_told(
    device: &Device,
    fixture: &Fixture,
    index: usize,
    told: &mut dyn FnMut(&Case) -> Result<()>,
) -> Result<()> {
    let Some(begun) = begin(device, fixture, index)? else { return Ok(()) };
    let Some((mut whole, list)) = begun.listed(device, fixture)? else { return Ok(()) };
    let count = whole.dispatches.len();
    whole.about.dispatches = match count {
        1 => "the only dispatch of the step".into(),
        _ => format!("all {count} dispatches of the step, in one submission"),
    };
    let mut now: Vec<Vec<u32>> = whole.buffers.iter().map(|part| part.before.clone()).collect();
    let mut done = 0;
    begun.trace(&mut |trace, next| {
        for dispatch in &trace.dispatches[done..] {
            for (buffer, words) in left(&list, dispatch) {
                now[buffer][..words.len()].copy_from_slice(&words);
            }
        }
        done = trace.dispatches.len();
        // Where the device counts other groups than the reference, an earlier dispatch is wrong.
        let same = |k: &usize| list.dispatches[*k].kernel == next.kernel && list.dispatches[*k].groups == next.groups;
        let index = Some(done).filter(|k| *k < count).filter(same);
        told(&index.map_or_else(|| whole.clone(), |k| beginning(&whole, &now, k)))
    })?;
    told(&whole)?;
    for _ in 0..RUNS {
        whole.run(device)?;
    }
    Ok(())
}

/// The case that begins with dispatch `k` of a step; `now` is what the buffers hold before it. The dispatch is alone if
/// no later one writes the same buffers; otherwise all later ones follow. If earlier ones have left words that are not
/// right at the end, the case has all dispatches.
fn beginning(whole: &Case, now: &[Vec<u32>], k: usize) -> Case {
    let (mut case, count) = (whole.clone(), whole.dispatches.len());
    let sound = case.buffers.iter().zip(now).all(|(part, now)| {
        (0..now.len()).all(|w| part.before[w] == now[w] || within(part.expected[w], now[w], part.allowed[w]))
    });
    if count == 1 {
        return case;
    }
    let number = k + 1;
    if !sound {
        case.about.dispatches = format!("all {count} dispatches of the step, and in dispatch {number}");
        return case;
    }
    let writes =
        |d: usize, b: usize| whole.dispatches[d].bindings.iter().any(|bound| bound.buffer == b && bound.writes);
    let again = |b: usize| (number..count).any(|d| writes(d, b));
    let alone = (0..case.buffers.len()).all(|b| !writes(k, b) || !again(b));
    let end = if alone { number } else { count };
    for (b, (part, now)) in case.buffers.iter_mut().zip(now).enumerate() {
        part.before.clone_from(now);
        part.device.clone_from(now);
        if !(k..end).any(|d| writes(d, b)) {
            part.expected.clone_from(now);
            part.allowed.fill(BITS);
        }
    }
    case.dispatches.truncate(end);
    case.dispatches.drain(..k);
    case.about.dispatches = match end - k {
        1 => format!("dispatch {number} of {count}"),
        _ => format!("dispatches {number} to {count} of {count}, and in the first of them"),
    };
    drop_unbound(&mut case);
    case
}

/// The case with fewer groups, if those still do not end, as `stays` finds. It is not known what the groups that are
/// left out should have written, so words that should change are not compared: the case passes if it ends.
pub fn least(case: &Case, stays: &mut dyn FnMut(&Case) -> Result<bool>) -> Result<Case> {
    let [dispatch] = &case.dispatches[..] else { return Ok(case.clone()) };
    let [across, 1, 1] = dispatch.groups else { return Ok(case.clone()) };
    let found = searched(across, &mut |count, first| {
        let Some(mut less) = grouped(case, count, first) else { return Ok(None) };
        for part in &mut less.buffers {
            let words = part.allowed.iter_mut().zip(part.before.iter().zip(&part.expected));
            words.filter(|(_, (before, expected))| before != expected).for_each(|(allowed, _)| *allowed = ANY);
        }
        Ok(stays(&less)?.then_some(less))
    })?;
    Ok(found.unwrap_or_else(|| case.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::repro::{Bound, Dispatch, Part};

    /// Two buffers of a word; dispatches that write the first, the first, and the second.
    fn three() -> Case {
        let part = |name: &str, expected: u32| Part {
            name: name.into(),
            before: vec![0],
            expected: vec![expected],
            allowed: vec![BITS],
            device: vec![0],
            ..Part::default()
        };
        let bound = |buffer: usize, writes: bool| Bound { number: buffer as u32, buffer, bytes: 4, writes };
        let dispatch = |to: usize| Dispatch {
            groups: [5, 1, 1],
            bindings: vec![bound(to, true), bound(1 - to, false)],
            ..Dispatch::default()
        };
        let buffers = vec![part("a", 3), part("b", 9)];
        Case { buffers, dispatches: vec![dispatch(0), dispatch(0), dispatch(1)], about: Default::default() }
    }

    #[test]
    fn a_dispatch_stands_alone_where_nothing_before_or_after_it_matters() {
        let case = beginning(&three(), &[vec![0], vec![0]], 0);
        assert!(case.dispatches.len() == 3 && case.about.dispatches.contains("1 to 3"), "{case:?}");
        let case = beginning(&three(), &[vec![3], vec![0]], 1);
        assert!(case.dispatches.len() == 1 && case.about.dispatches == "dispatch 2 of 3", "{case:?}");
        // What it reads stays as it is, whatever later ones write there.
        assert_eq!((case.buffers[0].expected[0], case.buffers[1].expected[0]), (3, 0));
        let case = beginning(&three(), &[vec![4], vec![0]], 1);
        assert!(case.dispatches.len() == 3 && case.buffers[0].before == [0], "{case:?}");
        assert!(case.about.dispatches.contains("in dispatch 2"), "{case:?}");
    }

    #[test]
    fn groups_that_end_are_left_out() {
        let case = beginning(&three(), &[vec![3], vec![0]], 2);
        let mut tries = 0;
        // The fourth group hangs; the kernel's groups can't be renumbered, so those before it stay.
        let mut stays = |case: &Case| {
            tries += 1;
            Ok(case.dispatches[0].groups[0] >= 4)
        };
        let less = least(&case, &mut stays).unwrap();
        assert_eq!((less.dispatches[0].groups, tries), ([4, 1, 1], 3), "{less:?}");
        assert_eq!((less.buffers[0].allowed[0], less.buffers[1].allowed[0]), (BITS, ANY));
        assert_eq!(least(&case, &mut |_| Ok(false)).unwrap(), case);
    }
}
