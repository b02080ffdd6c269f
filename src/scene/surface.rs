//! What a material's surface does with light that leaves it.

/// Switches of a surface; by default as published.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// Whether light that leaves is divided by 1 - F_ext, so that all of it does: the dipole's boundary term already has
    /// what is reflected back inside.
    pub normalize_exit: bool,
}
