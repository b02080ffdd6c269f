//! Where the wrong words of a buffer are: which fields, which elements, and whether these have something in common.

use crate::layout::{GROUP_SIZE, Word};

/// Characters of a map.
const CELLS: usize = 64;

/// Describes wrong words, given by their index in a buffer of elements of this layout; `part` is the first element that
/// was compared, and how many there are.
#[must_use]
pub fn pattern(wrong: &[usize], layout: &[Word], part: (usize, usize)) -> String {
    let mut fields: Vec<(&str, usize)> = Vec::new();
    for &word in wrong {
        let path = layout[word % layout.len()].path.as_str();
        match fields.iter_mut().find(|(known, _)| *known == path) {
            Some((_, count)) => *count += 1,
            None => fields.push((path, 1)),
        }
    }
    let mut elements: Vec<usize> = wrong.iter().map(|word| word / layout.len()).collect();
    elements.dedup();
    let own = part.0..part.0 + part.1;
    let outside = elements.iter().filter(|element| !own.contains(element)).count();
    if outside > 0 {
        return format!("{} elements, {outside} of them outside of the part that the step is given", elements.len());
    }
    let mut text = String::new();
    if fields.len() < layout.len() {
        let list: Vec<String> = fields.iter().map(|(path, count)| format!("{path} {count} times")).collect();
        text += &format!("only {}; ", list.join(", "));
    }
    let whole = elements.len() == part.1;
    text += &match (elements.as_slice(), whole) {
        ([one], _) => format!("element {one} of {}", part.1),
        (_, true) => format!("all {} elements", part.1),
        (several, _) => format!("{} of {} elements", several.len(), part.1),
    };
    // Counted from the first element of the part, as invocations are.
    let own: Vec<usize> = elements.iter().map(|element| element.saturating_sub(part.0)).collect();
    if own.len() < 2 || whole {
        return text;
    }
    let alike = [64, 32, 16, 8, 4, 2].into_iter().find(|by| own.iter().all(|element| element % by == own[0] % by));
    if let Some(by) = alike {
        text += &format!(", all of them {} modulo {by}", own[0] % by);
    }
    let group = GROUP_SIZE as usize;
    let groups: std::collections::BTreeSet<usize> = own.iter().map(|element| element / group).collect();
    let all = part.1.div_ceil(group);
    if all > 1 {
        text += &format!(", in {} of {all} groups of {group}", groups.len());
        if let ([first, ..], 1) = (own.as_slice(), groups.len()) {
            text += &format!(": number {}", first / group);
        }
    }
    let cells = CELLS.min(part.1);
    text += &format!(" [{}]", map(&own, part.1, cells, |element| (element * cells / part.1.max(1)).min(cells - 1)));
    if all > 1 {
        text += &format!(", by lanes of the groups [{}]", map(&own, part.1, group, |element| element % group));
    }
    text
}

/// A map of `cells` cells: `#` where all elements of a cell are wrong, `+` where some are, `.` where none is.
fn map(wrong: &[usize], all: usize, cells: usize, cell: impl Fn(usize) -> usize) -> String {
    let (mut counts, mut sizes) = (vec![0usize; cells], vec![0usize; cells]);
    wrong.iter().for_each(|&element| counts[cell(element)] += 1);
    (0..all).for_each(|element| sizes[cell(element)] += 1);
    let sign = |(&count, &size): (&usize, &usize)| match count {
        0 => '.',
        count if count >= size => '#',
        _ => '+',
    };
    counts.iter().zip(&sizes).map(sign).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Number;

    #[test]
    fn what_wrong_words_have_in_common_is_told() {
        let word = |path: &str| Word { path: path.into(), number: Number::Float };
        let layout = [word("x"), word("y"), word("z")];
        let words =
            |elements: &[usize]| elements.iter().flat_map(|e| [3 * e, 3 * e + 1, 3 * e + 2]).collect::<Vec<_>>();
        assert_eq!(pattern(&[10], &layout, (0, 8)), "only y 1 times; element 3 of 8");
        assert_eq!(pattern(&words(&[0, 1]), &layout, (0, 2)), "all 2 elements");
        let outside = pattern(&words(&[0, 9]), &layout, (0, 0));
        assert_eq!(outside, "2 elements, 2 of them outside of the part that the step is given");
        let lanes: Vec<usize> = (0..128).filter(|e| e % 4 == 1).collect();
        let text = pattern(&words(&lanes), &layout, (0, 128));
        assert!(text.starts_with("32 of 128 elements, all of them 1 modulo 4, in 2 of 2 groups of 64 [+.+."), "{text}");
        assert!(text.contains("], by lanes of the groups [.#...#...#"), "{text}");
        let group: Vec<usize> = (100 + 64..100 + 128).collect();
        let text = pattern(&words(&group), &layout, (100, 256));
        assert!(
            text.starts_with("64 of 256 elements, in 1 of 4 groups of 64: number 1 [................####"),
            "{text}"
        );
    }
}
