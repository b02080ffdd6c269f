//! Which dispatches of a step a failure needs.
//!
//! The reference says what a step leaves, not what each of its dispatches does. At fault is the first dispatch that
//! leaves a wrong word which no later one writes again. If every word that earlier dispatches have changed for it is
//! already as the step should leave it, the dispatch stands alone: the case begins with what the device had before it,
//! and words that later dispatches write are not compared. Otherwise the dispatches before it come along.

use std::collections::BTreeMap;

use super::{ANY, Case, within};

/// Leaves out what a failure does not need; `left` holds what each dispatch left in the buffers that it may write.
pub(super) fn isolate(mut case: Case, left: &[BTreeMap<usize, Vec<u32>>]) -> Case {
    // The buffers before each dispatch, and after the last one.
    let mut states: Vec<Vec<Vec<u32>>> = vec![case.buffers.iter().map(|part| part.before.clone()).collect()];
    for after in left {
        let mut state = states[states.len() - 1].clone();
        for (&buffer, words) in after {
            state[buffer][..words.len()].copy_from_slice(words);
        }
        states.push(state);
    }
    let count = case.dispatches.len();
    // The last dispatch that changes each wrong word.
    let mut culprit = None::<usize>;
    for (b, part) in case.buffers.iter().enumerate() {
        for word in part.wrong(&states[count][b]) {
            case.about.fails = true;
            let last = (0..count).rev().find(|&k| states[k][b][word] != states[k + 1][b][word]);
            culprit = culprit.into_iter().chain(last).min();
        }
    }
    let only = count == 1;
    let (first, last) = match culprit {
        Some(k) if only || sound_before(&case, &states, k) => (k, k),
        Some(k) => (0, k),
        None => (0, count - 1),
    };
    case.about.dispatches = match (only, culprit, first == last) {
        (true, _, _) => "the only dispatch of the step".into(),
        (_, Some(k), true) => format!("dispatch {} of {count}: the first that leaves a wrong value", k + 1),
        (_, Some(k), _) => {
            format!("dispatches 1 to {} of {count}: the last is the first that leaves a wrong value", k + 1)
        }
        (_, None, _) if case.about.fails => {
            format!("all {count} dispatches of the step: no one writes what is missing")
        }
        _ => format!("all {count} dispatches of the step"),
    };
    for (b, part) in case.buffers.iter_mut().enumerate() {
        for (word, allowed) in part.allowed.iter_mut().enumerate() {
            if (last + 1..count).any(|k| states[k][b][word] != states[k + 1][b][word]) {
                *allowed = ANY;
            }
        }
        part.before.clone_from(&states[first][b]);
        part.device.clone_from(&states[last + 1][b]);
    }
    case.dispatches.truncate(last + 1);
    case.dispatches.drain(..first);
    drop_unbound(&mut case);
    case
}

/// Whether all that earlier dispatches have changed in the buffers of a dispatch is right.
fn sound_before(case: &Case, states: &[Vec<Vec<u32>>], k: usize) -> bool {
    let mut bound = case.dispatches[k].bindings.iter().map(|binding| binding.buffer);
    bound.all(|b| {
        let part = &case.buffers[b];
        let (begin, now) = (&states[0][b], &states[k][b]);
        (0..now.len()).all(|w| begin[w] == now[w] || within(part.expected[w], now[w], part.allowed[w]))
    })
}

/// Leaves out the buffers that no dispatch binds.
pub(super) fn drop_unbound(case: &mut Case) {
    let bound = |b: usize| case.dispatches.iter().any(|d| d.bindings.iter().any(|binding| binding.buffer == b));
    let kept: Vec<usize> = (0..case.buffers.len()).filter(|&b| bound(b)).collect();
    let mut parts: Vec<_> = std::mem::take(&mut case.buffers).into_iter().map(Some).collect();
    case.buffers = kept.iter().filter_map(|&b| parts[b].take()).collect();
    for binding in case.dispatches.iter_mut().flat_map(|dispatch| &mut dispatch.bindings) {
        binding.buffer = kept.iter().position(|&b| b == binding.buffer).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::repro::{BITS, Bound, Dispatch, Part};

    /// Two words in a buffer, and dispatches that leave these values there.
    fn three(left: [[u32; 2]; 3], expected: [u32; 2]) -> Case {
        let part = Part {
            name: "a".into(),
            before: vec![0, 0],
            expected: expected.to_vec(),
            allowed: vec![BITS; 2],
            ..Part::default()
        };
        let bound = Bound { number: 0, buffer: 0, bytes: 8, writes: true };
        let dispatch = |k: u32| Dispatch { groups: [k, 1, 1], bindings: vec![bound], ..Dispatch::default() };
        let case = Case { buffers: vec![part], dispatches: (1..4).map(dispatch).collect(), about: Default::default() };
        isolate(case, &left.map(|words| BTreeMap::from([(0, words.to_vec())])))
    }

    #[test]
    fn the_first_dispatch_that_leaves_a_wrong_word_stands_alone() {
        let case = three([[1, 0], [1, 5], [3, 5]], [3, 2]);
        // The first word is written again by the third; before the second it is not what it is at the end.
        assert_eq!((case.dispatches.len(), &case.buffers[0].before[..]), (2, &[0, 0][..]), "{case:?}");
        assert_eq!((&case.buffers[0].allowed[..], &case.buffers[0].device[..]), (&[ANY, BITS][..], &[1, 5][..]));
        let case = three([[1, 0], [1, 5], [1, 5]], [1, 2]);
        assert_eq!((case.dispatches.len(), case.dispatches[0].groups[0]), (1, 2), "{case:?}");
        assert_eq!(case.buffers[0].before, [1, 0]);
        assert!(case.about.fails && case.about.dispatches.contains("2 of 3"), "{case:?}");
    }

    #[test]
    fn all_stay_where_nothing_is_wrong_or_no_one_writes_it() {
        let case = three([[1, 0], [1, 2], [1, 2]], [1, 2]);
        assert!(case.dispatches.len() == 3 && !case.about.fails);
        let case = three([[1, 0], [1, 0], [1, 0]], [1, 2]);
        assert!(case.dispatches.len() == 3 && case.about.fails, "{case:?}");
    }
}
