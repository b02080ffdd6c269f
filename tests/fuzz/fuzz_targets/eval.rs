//! Fuzzes the tables of `milkglass eval`; the first byte selects the table and the formula.
#![no_main]

use milkglass::measure::eval::{Kind, answers};
use milkglass::scene::Fresnel;
use std::path::Path;

#[global_allocator]
static MEMORY: cap::Cap<std::alloc::System> = cap::Cap::new(std::alloc::System, 256 << 20);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((way, text)) = bytes.split_first() else { return };
    let kind = [Kind::FormFactor, Kind::Profile, Kind::Layered, Kind::Cdrf][usize::from(way % 4)];
    let formula = if way & 4 == 0 { Fresnel::Paper } else { Fresnel::Exact };
    let _ = answers(kind, formula, Path::new("a.csv"), text, || Ok(None));
});
