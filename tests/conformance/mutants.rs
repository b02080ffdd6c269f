//! Mutants by name: kernels that do nothing (`idle`), a bit flipped in a buffer after a stage (`flipped`), kernels
//! whose results are multiplied by 1.00003 (`factor`). `mutants.txt` must list exactly those that are noticed.

use std::collections::BTreeSet;

/// Compares the noticed mutants of a kind with the list.
pub fn check(kind: &str, noticed: &BTreeSet<String>) {
    let lines = include_str!("mutants.txt").lines();
    let listed: BTreeSet<String> =
        lines.filter_map(|line| line.strip_prefix(kind)?.strip_prefix(' ')).map(String::from).collect();
    let unseen: Vec<_> = listed.difference(noticed).collect();
    assert!(unseen.is_empty(), "{kind}: went unseen: {unseen:#?}");
    let new: Vec<_> = noticed.difference(&listed).collect();
    assert!(new.is_empty(), "{kind}: mutants.txt lacks {new:#?}");
}
