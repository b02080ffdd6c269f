//! A file of constants for users' own kernels: `["transport/blocks/push"]`, then `NAME = value` or `ID = value`.

use std::io::Read as _;
use std::path::Path;

use toml::{Table, Value};

use crate::error::{Input, Result};
use crate::gpu::Given;
use crate::scene::{from_toml, line_of};

/// Most bytes of the file.
const MOST: u64 = 1 << 20;

/// The kernels of a file, with the line and the constants of each.
pub fn read(path: &Path) -> Result<Vec<(String, Option<usize>, Given)>> {
    let unread = |error: std::io::Error| Input::new(format!("the constants could not be read: {error}")).file(path);
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(unread)?;
    file.take(MOST + 1).read_to_string(&mut text).map_err(unread)?;
    if text.len() as u64 > MOST {
        return Err(Input::new("too long").file(path).expected(format!("at most {MOST} bytes")).into());
    }
    let table: Table = toml::from_str(&text).map_err(|error| from_toml(&error, &text, path))?;
    let mut kernels = Vec::new();
    for (kernel, constants) in table {
        let line = line_of(&text, &kernel);
        let Value::Table(constants) = constants else {
            let fault = Input { line, ..Input::new("not the table of a kernel").file(path).key(kernel) };
            return Err(fault.found(constants).expected("[\"transport/blocks/push\"], for example").into());
        };
        let with_line = |(name, value): (String, Value)| {
            let line = line_of(&text, &format!("{kernel}.{name}"));
            (name, line, value)
        };
        let values = constants.into_iter().map(with_line).collect();
        kernels.push((kernel, line, Given { file: path.to_path_buf(), values }));
    }
    Ok(kernels)
}
