//! The plot of a fit, as figure 6 of Kubo et al. 2010: one panel per channel, exitant light over the angle.

use plotters::prelude::*;

use crate::error::{Error, Result};
use crate::shading::balls::{ANGLES, Curve, angle};
use crate::shading::reflectance::cdrf;

/// The results for one channel.
pub struct Panel<'a> {
    /// Its name.
    pub name: &'a str,
    /// The dipole's curves, one per radius.
    pub dipole: &'a [Curve],
    /// The random walk's curves, one per radius.
    pub walk: &'a [Curve],
    /// sigma_0 fitted to the dipole.
    pub sigma_0: f64,
}

/// Size of a panel, pixels.
const SIZE: (u32, u32) = (520, 440);

/// Draws the plot: lines are f at the fitted sigma_0, circles the dipole, bars the random walk with twice its
/// standard error.
pub fn svg(title: &str, panels: &[Panel<'_>]) -> Result<String> {
    let mut picture = String::new();
    draw(&mut picture, title, panels).map_err(|error| Error::Check(format!("the plot could not be drawn: {error}")))?;
    Ok(picture)
}

fn draw(
    picture: &mut String,
    title: &str,
    panels: &[Panel<'_>],
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let size = (SIZE.0 * panels.len() as u32, SIZE.1 + 30);
    let root = SVGBackend::with_string(picture, size).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(title, ("sans-serif", 18))?;
    let most = panels.iter().flat_map(|panel| panel.dipole.iter().chain(panel.walk)).flat_map(|curve| &curve.values);
    // Few photons leave far from the light: the noisy values there may lie outside the plot.
    let top = 1.05 * most.fold(1.0, |a: f64, &b| a.max(b.min(1.2)));
    for (area, panel) in root.split_evenly((1, panels.len())).iter().zip(panels) {
        let caption = format!("{}: sigma_0 = {:.3} mm", panel.name, panel.sigma_0);
        let mut chart = ChartBuilder::on(area)
            .caption(caption, ("sans-serif", 15))
            .margin(8)
            .margin_right(20)
            .x_label_area_size(36)
            .y_label_area_size(44)
            .build_cartesian_2d(0.0..180.0, 0.0..top)?;
        chart
            .configure_mesh()
            .x_desc("angle from the light, degrees")
            .y_desc("light that leaves, of a plane's")
            .x_label_formatter(&|degrees: &f64| format!("{degrees:.0}"))
            .light_line_style(WHITE)
            .draw()?;
        for (number, curve) in panel.dipole.iter().enumerate() {
            let color = HSLColor(0.66 * number as f64 / panel.dipole.len() as f64, 0.85, 0.4);
            let line = (0..=180).map(|degree| {
                let theta = f64::from(degree).to_radians();
                (f64::from(degree), cdrf(theta.cos(), panel.sigma_0 / curve.radius))
            });
            chart
                .draw_series(LineSeries::new(line, color.stroke_width(2)))?
                .label(format!("radius {:.3} mm", curve.radius))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color.stroke_width(2)));
            let degree = |k: usize| angle(k).to_degrees();
            chart.draw_series((0..ANGLES).map(|k| Circle::new((degree(k), curve.values[k]), 2, color.filled())))?;
            let Some(walk) = panel.walk.get(number) else { continue };
            chart.draw_series((0..ANGLES).map(|k| {
                let (value, error) = (walk.values[k], 2.0 * walk.errors[k]);
                PathElement::new(
                    [(degree(k), (value - error).max(0.0)), (degree(k), value + error)],
                    color.stroke_width(1),
                )
            }))?;
        }
        chart.configure_series_labels().position(SeriesLabelPosition::UpperRight).background_style(WHITE).draw()?;
    }
    root.present()?;
    Ok(())
}
