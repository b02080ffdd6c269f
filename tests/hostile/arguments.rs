//! Invalid command lines.

use super::Case;

const BALL: &str = "sphere --set object.0.detail=0 --device cpu";

pub fn cases() -> Vec<Case> {
    let lines = [pictures(), other_commands()].concat();
    lines.into_iter().map(|(line, words)| Case::new(&[], &line, words)).collect()
}

fn pictures() -> Vec<(String, &'static str)> {
    let deep = format!("render {BALL} -o a.png --set {}b=1", "a.".repeat(40_000));
    vec![
        (format!("render {BALL} -o a.gif"), "-o: a picture's name says its format; found .gif; expected .png or .exr"),
        (format!("render {BALL} -o ''"), "-o: a picture's name says its format"),
        (format!("render {BALL} -o a.png --size 0x0"), "--size: not a picture size; found 0x0; expected WxH"),
        (format!("render {BALL} -o a.png --size 16385x1"), "--size: not a picture size"),
        (format!("render {BALL} -o a.png --size 99999999999999999999x1"), "--size: not a picture size"),
        (format!("render {BALL} -o a.png --size 16384x16384"), "a frame does not fit the memory"),
        (format!("render {BALL} -o a.png --size -4x4"), "unexpected argument '-4'"),
        (format!("render {BALL} -o a.png --size 4x4 --set camera.samples=1e9"), "--set camera.samples=1e9"),
        (format!("render {BALL} -o a.png --limit-memory 0"), "--limit-memory"),
        (format!("render {BALL} -o a.png --limit-memory lots"), "--limit-memory"),
        (format!("render {BALL} -o a.png --limit-memory 99999999T"), "--limit-memory"),
        (format!("render {BALL} -o a.png --limit-memory 10K"), "a frame does not fit the memory"),
        (format!("render {BALL} -o a-%d.png --frames 5..4"), "--frames: not a range of frames; found 5..4"),
        (format!("render {BALL} -o a-%d.png --frames 0..99999999"), "--frames: not a range of frames"),
        (format!("render {BALL} -o a.png --frames 0..3"), "--output: every frame needs a file of its own"),
        (format!("render {BALL} -o %99999999999999999999d.png --frames 0..3"), "every frame needs a file of its own"),
        (format!("render {BALL} -o a.png --frame nan"), "--frame: not a frame; found NaN"),
        (format!("render {BALL} -o a.png --frame 1e999"), "--frame: not a frame; found inf"),
        (format!("render {BALL} -o gone/a.png --size 4x4"), "gone/a.png: could not be written"),
        (format!("render {BALL} -o a.png --view clusters"), "--pick: --view clusters and --pick X,Y go together"),
        (format!("render {BALL} -o a.png --view clusters --pick 9999999,0"), "--pick"),
        (format!("render {BALL} -o a.png --view clusters --pick -1,0"), "unexpected argument '-1'"),
        (format!("render {BALL} -o a.png --aov"), "--aov: only OpenEXR has layers"),
        (format!("render {BALL} -o a.png --transport teleport"), "--transport"),
        (format!("render {BALL} -o a.png --mode sometimes"), "--mode"),
        (format!("render {BALL} -o a.png --set object.0"), "--set object.0: not a setting"),
        (format!("render {BALL} -o a.png --set object.999999999999.size=1"), "`object` is a list of 1"),
        (format!("render {BALL} -o a.png --set =1"), "--set =1: an empty name"),
        (deep, "a key of too many names; found 40001; expected at most 16"),
        (format!("render {BALL} -o a.png --set x={}", "[".repeat(9000)), "unknown key"),
        (format!("render {BALL} -o a.png --set transport.subdivide=99"), "transport.subdivide: out of range"),
    ]
}

fn other_commands() -> Vec<(String, &'static str)> {
    vec![
        (String::new(), "Usage"),
        ("rendr sphere".into(), "unrecognized subcommand"),
        ("render".into(), "required"),
        ("render sphere".into(), "required"),
        ("solve lotus -o a.csv --device cpu --limit-memory 1M".into(), "object: the shapes do not fit the memory"),
        ("render spher -o a.png --device cpu".into(), "neither a built-in scene nor a file, did you mean `sphere`?"),
        ("render . -o a.png --device cpu".into(), "the scene file cannot be read"),
        ("render /dev/zero -o a.png --device cpu".into(), "/dev/zero: the scene file cannot be read"),
        ("render /dev/null -o a.png --device cpu".into(), "found a device, which may never end"),
        (format!("solve {BALL}"), "nothing to do; expected -o FILE"),
        (format!("solve {BALL} -o a.txt"), "-o: the name says the format; found a.txt"),
        (format!("solve {BALL} --verify 0"), "--verify"),
        (format!("solve {BALL} --verify -3"), "--verify"),
        (format!("solve {BALL} -o a.csv --seed 99999999999999999999"), "--seed"),
        (format!("pareto {BALL} --methods magic"), "--methods"),
        (format!("pareto {BALL} --budget nan"), "--budget: out of range"),
        (format!("pareto {BALL} --samples 0"), "--samples"),
        ("eval magic a.csv -o b.csv".into(), "magic"),
        ("eval profile gone.csv -o b.csv --device cpu".into(), "gone.csv: No such file"),
        ("eval profile /dev/zero -o b.csv --device cpu --limit-memory 64M".into(), "/dev/zero: "),
        ("eval profile a.csv -o a.csv --device cpu".into(), "-o: the output would replace the input"),
        ("bake-layers a.obj -o a.png".into(), "required"),
        ("bake-layers gone.obj gone.obj -o a.png".into(), "gone.obj: there is no such mesh file"),
        ("bake-layers gone.obj gone.obj -o a.png --size 99999x99999".into(), "--size: not the size of a map"),
        ("fit-cdrf unobtainium".into(), "MATERIAL: no material of this name"),
        ("fit-cdrf marble --photons 0".into(), "--photons: out of range; found 0"),
        ("scenes nowhere".into(), "nowhere"),
        ("shader nowhere/at/all".into(), "nowhere"),
    ]
}
