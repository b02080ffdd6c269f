//! The user guide. Its pages are `src/guide/*.md`, which also read well in the repository.

/// A page: links between pages lead to modules here, and to files in the repository.
macro_rules! pages {
    ($($name:ident)*) => { $(
        #[doc = concat!("\n", "[start]: crate::guide::start\n", "[scenes]: crate::guide::scenes\n", "[lights]: crate::guide::lights\n", "[motion]: crate::guide::motion\n", "[layers]: crate::guide::layers\n", "[curvature]: crate::guide::curvature\n", "[how]: crate::guide::how\n", "[measuring]: crate::guide::measuring\n", "[conformance]: crate::guide::conformance\n", "[performance]: crate::guide::performance\n", "[robustness]: crate::guide::robustness\n", "[library]: crate::guide::library\n", "[contributing]: crate::guide::contributing\n")]
        #[doc = include_str!(concat!("guide/", stringify!($name), ".md"))]
        pub mod $name {}
    )* };
}

pages! { start scenes lights motion layers curvature how measuring conformance performance robustness library contributing }
