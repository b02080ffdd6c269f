//! How a constant that host and device share is declared: once, as a Rust `pub const` that also becomes a GLSL `const`
//! in `layout.glsl`. The numbers are in `numbers.rs`, the values that a field or a decision may take in `kinds.rs`.

/// A shared constant, as the build script and the tests see it.
pub struct Constant {
    /// Its name on both sides.
    pub name: &'static str,
    /// Its GLSL type.
    pub kind: String,
    /// Its value in GLSL.
    pub value: String,
}

/// A value that can be written in both languages.
pub trait Shared {
    /// Its GLSL type.
    fn kind() -> String;
    /// The value as a GLSL expression, exact up to rounding to GLSL's type.
    fn value(&self) -> String;
}

impl Shared for u32 {
    fn kind() -> String {
        "uint".into()
    }
    fn value(&self) -> String {
        format!("{self}u")
    }
}

impl Shared for usize {
    fn kind() -> String {
        "uint".into()
    }
    fn value(&self) -> String {
        format!("{self}u")
    }
}

impl Shared for f32 {
    fn kind() -> String {
        "float".into()
    }
    fn value(&self) -> String {
        f64::from(*self).value()
    }
}

impl Shared for f64 {
    fn kind() -> String {
        "float".into()
    }
    fn value(&self) -> String {
        format!("{self:?}")
    }
}

impl<T: Shared, const N: usize> Shared for [T; N] {
    fn kind() -> String {
        format!("{}[{N}]", T::kind())
    }
    fn value(&self) -> String {
        let values: Vec<String> = self.iter().map(Shared::value).collect();
        format!("{}({})", Self::kind(), values.join(", "))
    }
}

macro_rules! constants {
    (
        $(#[doc = $list_about:literal])* $list:ident:
        $($(#[doc = $about:literal])* $name:ident: $kind:ty = $value:expr;)*
    ) => {
        $($(#[doc = $about])* pub const $name: $kind = $value;)*

        $(#[doc = $list_about])*
        pub fn $list() -> Vec<Constant> {
            vec![$(Constant {
                name: stringify!($name),
                kind: <$kind as Shared>::kind(),
                value: Shared::value(&$name),
            },)*]
        }
    };
}
