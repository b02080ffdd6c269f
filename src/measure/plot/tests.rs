use super::*;

#[test]
fn a_plot_names_its_axes_and_leaves_out_what_has_no_place() {
    let series = [
        Series::line("up & down", [(1.0, 1.0), (2.0, 0.0), (3.0, 5.0)]),
        Series::dots("odd", [(2.0, f64::NAN), (2.0, 2.0)]),
    ];
    for (a, b) in [(false, false), (true, false), (false, true), (true, true)] {
        let axis = |label, log| if log { Axis::log(label) } else { Axis::linear(label) };
        let axes = [axis("x, mm", a), axis("y, W", b)];
        let svg = Panel::new("a plot", axes.clone(), series.clone()).svg().unwrap();
        for words in ["<svg", "a plot", "x, mm", "y, W", "up &amp; down", "odd"] {
            assert!(svg.contains(words), "{words}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        // A plot without data is not an error.
        assert!(Panel::new("empty", axes, []).svg().unwrap().contains("empty"));
    }
    assert!(Plot { title: vec!["none".into()], ..Plot::default() }.svg().unwrap().contains("none"));
}

#[test]
fn logarithmic_axes_hold_their_numbers_and_at_least_a_decade() {
    let axis = Axis::log("ms");
    let [low, high] = axis.range([3.0, 5.0, 0.0, f64::NAN].into_iter());
    assert!(low < 3.0 && high > 5.0 && high >= 9.99 * low, "{low} {high}");
    assert_eq!(axis.range(std::iter::empty()), [1.0, 10.0]);
}

#[test]
fn labelled_ticks_are_round() {
    let labels = |axis: Axis, ends| axis.ticks(ends)[0].iter().map(|tick| axis.name(*tick)).collect::<Vec<_>>();
    assert_eq!(labels(Axis::log(""), [8.0, 126.0]), ["10", "20", "50", "100"]);
    assert_eq!(labels(Axis::log(""), [1e-5, 0.03]), ["1e-5", "1e-4", "1e-3", "1e-2"]);
    assert_eq!(labels(Axis::linear(""), [0.9, 1.3]), ["0.9", "1", "1.1", "1.2", "1.3"]);
    assert_eq!(labels(Axis::names(vec!["a".into(), "b".into()]), [1.5, -0.5]), ["a", "b"]);
}

#[test]
fn panels_that_share_have_one_legend() {
    let panel = |title: &str| {
        let curve = Series::new("a curve", Mark::Curve, [(1.0, 2.0), (2.0, 1.0)]);
        let band = Series::new("a band", Mark::Band, [(1.0, 2.0)]);
        Panel::new(title, [Axis::log("x"), Axis::log("y")], [curve, band])
    };
    let plot = |shared| Plot { panels: vec![panel("one"), panel("two")], columns: 2, shared, title: Vec::new() };
    for (shared, count) in [(true, 1), (false, 2)] {
        let svg = plot(shared).svg().unwrap();
        assert_eq!((svg.matches("a curve").count(), svg.matches("a band").count()), (count, count));
        assert!(svg.contains("one") && svg.contains("two"));
    }
}
