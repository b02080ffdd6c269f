//! `compile`: what RADV makes of kernels for GPUs that are not here. Left out where RADV is not installed.

use super::conform::planted;
use crate::shell::{bad, folder, good, program, read, said};

#[test]
fn a_spill_is_found_without_the_gpu() {
    let here = folder(&[]);
    let line = "compile sphere --set object.0.detail=2 --for";
    let (_, err) = said(&program(&here, &format!("{line} nonsense")).output().unwrap());
    if err.contains("there is no RADV") {
        println!("not tested: RADV is not installed");
        return;
    }
    bad(&here, &format!("{line} nonsense"), 1, &["nonsense: ", "1 compilers failed"]);
    let (out, _) = good(&here, &format!("{line} navi21,vega10 --csv a.csv"));
    for words in
        ["navi21: Null hardware", "vega10: Null hardware", "registers", "waves", "transport/blocks/gather/direct"]
    {
        assert!(out.contains(words), "{words}: {out}");
    }
    let rows = read(&here, "a.csv");
    assert!(rows.starts_with("compiler,kernel,constants,statistic,value\n"), "{rows}");
    let (again, _) = good(&here, &format!("{line} navi21,vega10 --csv b.csv --baseline a.csv"));
    assert!(rows == read(&here, "b.csv") && again.contains("transport/blocks/push"), "{again}");
    // A table of its own for each invocation, too large for registers.
    planted(&here, "spill.comp", "max(sum + held(sum), vec3(0))");
    let text = read(&here, "spill.comp").replacen(
        "void main()",
        "vec3 held(vec3 sum) {\n    float many[999];\n    for (uint i = 0u; i < 999u; i++) many[(i * 7u) % 999u] = sum.x * float(i);\n    \
         return vec3(many[uint(abs(sum.y)) % 999u]);\n}\n\nvoid main()",
        1,
    );
    std::fs::write(here.path().join("spill.comp"), text).unwrap();
    let spilt = format!("{line} navi21 --baseline a.csv --replace transport/blocks/push=spill.comp");
    let said =
        bad(&here, &spilt, 1, &["navi21: transport/blocks/push: scratch 0 -> ", "worse than those of the baseline"]);
    assert!(!said.contains("gather/direct: scratch"), "{said}");
    bad(&here, &format!("{line} navi21 --baseline none.csv"), 2, &["none.csv", "could not be read"]);
}
