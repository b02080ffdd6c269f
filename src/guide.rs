//! The user guide. Its pages are `src/guide/*.md`, which also read well in the repository.

/// Each name is a page. Links between pages lead to modules here, and to files in the repository: of two definitions
/// of a link the first one counts.
macro_rules! pages {
    ($($name:ident)*) => {
        pages!(@each [$($name)*] $($name)*);
    };
    (@each $all:tt $($name:ident)*) => { $(pages!(@one $all $name);)* };
    (@one [$($all:ident)*] $name:ident) => {
        #[doc = concat!($("[", stringify!($all), "]: crate::guide::", stringify!($all), "\n"),*)]
        #[doc = ""]
        #[doc = include_str!(concat!("guide/", stringify!($name), ".md"))]
        pub mod $name {}
    };
}

pages! {
    start scenes lights motion layers curvature how measuring conformance performance robustness library contributing
}
