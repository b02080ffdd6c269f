//! The first frame on llvmpipe, with an empty cache on disk, a filled one, and none.

use crate::shell::{bytes, folder, program, said};

#[test]
fn new_kernels_are_compiled_ahead() {
    let here = folder(&[]);
    let cache = tempfile::tempdir().unwrap();
    let render = |line: &str, extra: Option<(&str, &str)>| {
        let mut command = program(&here, &format!("{line} sphere --set object.0.detail=2"));
        let output = command.env("MESA_SHADER_CACHE_DIR", cache.path()).envs(extra).output().unwrap();
        let (out, err) = said(&output);
        assert!(output.status.success(), "{out}{err}");
        (out.clone(), out.contains("compiling kernels"), err.contains("llvmpipe"))
    };
    let (out, ahead, llvmpipe) = render("render -o first.png --size 64x48 --times", None);
    assert_eq!(ahead, llvmpipe, "{out}");
    render("render -o again.png --size 64x48 --times", None);
    assert_eq!(bytes(&here, "first.png"), bytes(&here, "again.png"));
    // Without a cache there is nobody to compile for.
    let (out, ahead, _) =
        render("render -o none.png --size 64x48 --times", Some(("MESA_SHADER_CACHE_DISABLE", "true")));
    assert!(!ahead && bytes(&here, "first.png") == bytes(&here, "none.png"), "{out}");
}
