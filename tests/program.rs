//! The program: its commands, its messages on malformed input, its documentation, and its window.

mod shell;

mod command;
mod hostile;
#[cfg(feature = "window")]
mod window;
