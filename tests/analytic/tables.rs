//! The parts of the paper's tables and figures that need no timing: figures 3 and 4, and CSV files of their curves.

use milkglass::measure::tables::curves::{Point, figure_3, figure_4};
use milkglass::measure::tables::given::compare_text;
use milkglass::measure::tables::paper::{TABLE_3, TABLE_4, TABLE_5};

fn at(points: &[Point], channel: usize, place: f64) -> Point {
    *points.iter().find(|p| p.channel == channel && (p.place - place).abs() <= 1e-5 * place).unwrap()
}

#[test]
fn figure_3_ours_is_exact_where_twelve_samples_are_not() {
    let points = figure_3();
    assert_eq!(points.len(), 3 * 51);
    // At the tip, by arbitrary-precision quadrature of this very triangle.
    assert!((at(&points, 0, 0.0).exact / 0.121_888_507_6 - 1.0).abs() < 1e-9);
    for p in &points {
        let [usual, finest] = p.ours.map(|(_, value)| p.error(value).abs());
        assert!(usual < 1e-2 && finest < 1e-4, "{p:?}");
        // The paper's segments: within 17 %. Random samples: over 5 % with 12 of them, under 4 % with 10,000.
        assert!(p.error(p.paper.value).abs() < 0.17, "{p:?}");
        let random = |n: f64| p.scatter / n.sqrt();
        assert!(random(12.0) > 0.05 && random(1e4) < 0.04, "{p:?}");
    }
    let worst = points.iter().map(|p| p.error(p.paper.value).abs()).fold(0.0, f64::max);
    assert!(worst > 0.1, "the segments' error is about 16 %, found {worst}");
    // Values fall with distance from the tip.
    assert!(points.windows(2).all(|w| w[0].channel != w[1].channel || w[0].exact > w[1].exact));
}

#[test]
fn figure_4_ours_keeps_to_eighteen_evaluations() {
    let points = figure_4();
    assert_eq!(points.len(), 3 * 31);
    let green = [(0.1, 8), (1.0, 8), (3.16228, 6), (10.0, 16), (31.6228, 32), (100.0, 128)];
    for (base, segments) in green {
        let point = at(&points, 1, base);
        assert_eq!(point.paper.segments, 2 * segments, "{point:?}");
        assert!(point.loose.segments <= 2 * 8);
    }
    for p in &points {
        let [usual, finest] = p.ours.map(|(_, value)| p.error(value).abs());
        assert!(usual < 2e-2 && finest < 1e-4, "{p:?}");
        assert!(p.ours.iter().all(|(evaluations, _)| *evaluations <= 18));
    }
    // The last triangle takes over 20,000 samples by Jensen and Buhler's criterion, and their rms error is still over
    // 0.3.
    let last = at(&points, 1, 100.0);
    assert!(last.discs > 20_000 && last.scatter / (last.discs as f64).sqrt() > 0.3, "{last:?}");
}

#[test]
fn a_file_of_a_figure_is_compared_row_by_row() {
    let point = at(&figure_3(), 2, 5.0);
    let error = point.error(point.paper.value);
    let head = "channel,tip_distance_cm,F_reference,n_segments,relerr_paper,MC12_rel_rms";
    let row = |exact: f64| {
        let (segments, scatter) = (point.paper.segments, point.scatter / 12f64.sqrt());
        format!("{head}\nB,0.5,{exact},{segments},{error},{scatter}\nB,0.511,1,1,1,1\n")
    };
    let found = compare_text(&row(point.exact)).unwrap();
    assert_eq!((found.figure, found.rows, found.segments), (3, 1, 1));
    assert!(found.exact < 1e-14 && found.paper < 1e-14 && found.scatter < 1e-14, "{found:?}");
    assert!((compare_text(&row(point.exact * 1.01)).unwrap().exact - 0.0099).abs() < 1e-4);
    assert!(compare_text("channel,x\n").is_err_and(|fault| fault.contains("base_distance_mm")));
    assert!(compare_text(&format!("{head}\nB,x,1,1,1,1\n")).is_err_and(|fault| fault.contains("`x`")));
}

#[test]
fn the_papers_numbers_are_those_it_prints() {
    // The paper rounds links per triangle to 44.1, 47.5, 53.3, 52.7 (the last is 52.4 by the counts of its row).
    let ratios = TABLE_3.each_ref().map(|row| 1e3 * row.kilolinks / row.faces as f64);
    for (found, printed) in ratios.into_iter().zip([44.1, 47.5, 53.3, 52.4]) {
        assert!((found - printed).abs() < 0.06, "{found} {printed}");
    }
    assert_eq!(TABLE_4.each_ref().map(|row| row.ms).iter().sum::<f64>(), 559.0);
    assert_eq!(TABLE_5.each_ref().map(|row| row.ms[1]), [162.0, 168.0, 222.0, 501.0, 1778.0]);
}
