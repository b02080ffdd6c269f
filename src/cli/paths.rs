//! Paths on the command line: names that are not UTF-8, and pipes.

use std::path::Path;

use clap::builder::{OsStringValueParser, TypedValueParser};

use milkglass::scene::text_of_path;

/// Takes any path as text, also one that is not UTF-8.
pub(super) fn any_path() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().map(text_of_path)
}

/// Says, once in a process, that a named pipe is being waited for: reading it may take for ever.
pub(super) fn announce_pipe(path: &Path) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        static SAID: std::sync::Once = std::sync::Once::new();
        if std::fs::symlink_metadata(path).is_ok_and(|known| known.file_type().is_fifo()) {
            SAID.call_once(|| tell!("{}: a pipe; waiting until its writer closes it", path.display()));
        }
    }
}
