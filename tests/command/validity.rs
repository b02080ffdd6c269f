//! `milkglass validity` run as a program.

use crate::shell::{bad, folder, good, numbers, read};

#[test]
fn a_large_ball_is_within_and_a_thin_slab_is_not() {
    let here = folder(&[]);
    let ball = "--device cpu --set object.0.detail=4 --set object.0.size=200 --set light.0.shadows=false";
    let (out, _) = good(&here, &format!("validity sphere {ball} --csv ball.csv --svg ball.svg"));
    assert!(out.lines().last().unwrap().starts_with("within 10 %: error"), "{out}");
    assert!(read(&here, "ball.svg").starts_with("<svg"));
    let text = read(&here, "ball.csv");
    let (header, rows) = numbers(&text);
    assert_eq!(header, "object,triangle,channel,area,sigma,thickness_over_sigma_0,B_dipole,B_cdrf,B_lambert");
    assert_eq!(rows.len(), 3 * 5120);
    // A ball of diameter 200 mm: a thickness of 200 mm below every triangle, and a curvature of 1/100.
    let sigma_0: Vec<f64> = (0..3).map(|c| rows[c][4] * 100.0).collect();
    for row in &rows {
        let thickness = row[5] * sigma_0[row[2] as usize];
        assert!((thickness / 200.0 - 1.0).abs() < 0.02 && row[6] > 0.0, "{row:?}");
    }

    assert!(out.lines().any(|line| line.starts_with("all: ") && line.contains("; Lambert: ")), "{out}");
    assert!(out.contains("all") && out.lines().any(|line| line.trim_end().ends_with("Lambert")), "{out}");

    // Light from behind crosses a thin slab, which curvature alone cannot show.
    let slab = "--device cpu --set object.0.detail=8 --set object.0.size=4";
    let (out, _) = good(&here, &format!("validity slab {slab}"));
    assert!(!out.lines().last().unwrap().starts_with("within 10 %: "), "{out}");
    bad(&here, "validity sphere --device cpu --set light.0.irradiance=0", 2, &["no light shines"]);
    bad(
        &here,
        "validity sphere --device cpu --set object.0.material={opaque=true}",
        2,
        &["no light enters any object"],
    );
}
