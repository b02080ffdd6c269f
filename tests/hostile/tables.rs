//! Malformed tables for `eval`.

use super::Case;

const FACTOR: &str = "v0x,v0y,v0z,v1x,v1y,v1z,v2x,v2y,v2z,xox,xoy,xoz,sigma_s_prime,sigma_a,eta\n";
const PROFILE: &str = "r,sigma_s_prime,sigma_a,eta\n";
const LAYERED: &str = "light,layers,thickness1,sigma_s1,sigma_t1,g1,lx,ly,lz,intensity,wox,woy,woz\n";

pub fn cases() -> Vec<Case> {
    let profile = |row: &str| ("profile", format!("{PROFILE}1,2,0.1,1.3\n{row}\n"));
    let factor = |row: &str| ("form-factor", format!("{FACTOR}{row}\n"));
    let layered = |row: &str| ("layered", format!("{LAYERED}{row}\n"));
    let cdrf = |row: &str| ("cdrf", format!("cos_theta,sigma\n{row}\n"));
    let cases: Vec<((&str, String), &'static str)> = vec![
        (("profile", String::new()), "a.csv:1: r: this column is missing"),
        (("form-factor", "\n\n".into()), "a.csv:1: v0x: this column is missing"),
        (("profile", "\0\0".into()), "a.csv:1: r: this column is missing"),
        (("profile", "R,sigma_s_prime,sigma_a,eta\n1,1,1,1".into()), "a.csv:1: r: this column is missing"),
        (("profile", "r;sigma_s_prime;sigma_a;eta\n1;1;1;1".into()), "a.csv:1: r: this column is missing"),
        (profile("1,2,0.1"), "a.csv:3: "),
        (profile("1,2,0.1,1.3,9"), "a.csv:3: "),
        (profile("x,2,0.1,1.3"), "a.csv:3: r: not a finite number; found \"x\"; expected a number"),
        (profile(",2,0.1,1.3"), "a.csv:3: r: not a finite number; found \"\""),
        (profile("nan,2,0.1,1.3"), "a.csv:3: r: not a finite number; found \"nan\""),
        (profile("1e999,2,0.1,1.3"), "a.csv:3: r: not a finite number; found \"1e999\""),
        (profile("-1,2,0.1,1.3"), "a.csv:3: r: out of range; found -1; expected at least 0"),
        (profile("1,-2,0.1,1.3"), "a.csv:3: sigma_s_prime: out of range; found -2"),
        (profile("1,2,-0.1,1.3"), "a.csv:3: sigma_a: out of range; found -0.1"),
        (profile("1,0,0,1.3"), "a.csv:3: sigma_s_prime: the medium neither scatters nor absorbs"),
        (profile("1,1e-320,0,1.3"), "a.csv:3: sigma_s_prime: "),
        (profile("1,1e308,1e308,1.3"), "a.csv:3: sigma_s_prime: "),
        (profile("1,2,0.1,0.4"), "a.csv:3: eta: out of range; found 0.4; expected at least 0.5"),
        (profile("1,2,0.1,3.9"), "a.csv:3: eta: the polynomial F_dr reaches 1"),
        (profile("\"1,2,0.1,1.3"), "a.csv:3: "),
        (profile("1,2,0.1,1.3\n\"\"\"x\",2,0.1,1.3"), "a.csv:4: r: not a finite number"),
        (profile("\u{661},2,0.1,1.3"), "a.csv:3: r: not a finite number"),
        (factor("0,0,0,0,0,0,0,0,0,1,1,1,2,0.1,1.3"), "a.csv:2: v0x: the triangle has no area"),
        (factor("0,0,0,1,0,0,2,0,0,1,1,1,2,0.1,1.3"), "a.csv:2: v0x: the triangle has no area"),
        (factor("0,0,0,1,0,0,0,1,0,1,1,inf,2,0.1,1.3"), "a.csv:2: xoz: not a finite number; found \"inf\""),
        (factor("0,0,0,1e300,0,0,0,1e300,0,1,1,1,2,0.1,1.3"), "a.csv:2: v0x: "),
        (factor("1,2"), "a.csv:2: "),
        (cdrf("1.5,1"), "a.csv:2: cos_theta: out of range; found 1.5; expected -1 to 1"),
        (cdrf("0,-1"), "a.csv:2: sigma: out of range; found -1"),
        (cdrf("0,"), "a.csv:2: sigma: not a finite number"),
        (layered("sun,1,1,1,2,0,0,0,1,1,0,0,1"), "a.csv:2: light: not a kind of light; found \"sun\""),
        (layered("point,0,1,1,2,0,0,0,1,1,0,0,1"), "a.csv:2: layers: not a number of layers; found \"0\""),
        (layered("point,2,1,1,2,0,0,0,1,1,0,0,1"), "a.csv:2: thickness2: this column is missing"),
        (layered("point,1,1,3,2,0,0,0,1,1,0,0,1"), "a.csv:2: sigma_t1: extinction is less than scattering"),
        (layered("point,1,1,1,2,1,0,0,1,1,0,0,1"), "a.csv:2: g1: out of range; found 1"),
        (layered("point,1,1,1,2,0,0,0,-1,1,0,0,1"), "a.csv:2: lz: the light is not above the slab"),
        (layered("point,1,1,1,2,0,0,0,1,1,0,0,0"), "a.csv:2: woz: the eye is not above the slab"),
        (layered("point,1,1,1,2,0,1e200,0,1,1,0,0,1"), "a.csv:2: light: the light is too far away"),
        (layered("point,99999999999999999999,1,1,2,0,0,0,1,1,0,0,1"), "a.csv:2: layers: not a number of layers"),
    ];
    let case = |((kind, text), words): ((&str, String), &'static str)| {
        let line = format!("eval {kind} a.csv -o b.csv --device cpu");
        Case::new(&[("a.csv", text.as_bytes())], &line, words)
    };
    let mut cases: Vec<Case> = cases.into_iter().map(case).collect();
    let bytes = [PROFILE.as_bytes(), b"1,2,0.1,1.3\n\xff,2,0.1,1.3\n"].concat();
    cases.push(Case::new(&[("a.csv", &bytes)], "eval profile a.csv -o b.csv --device cpu", "a.csv:3: "));
    cases
}
