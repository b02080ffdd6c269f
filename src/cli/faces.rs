//! Results of `solve` per face, as CSV and as PLY.

use std::fmt::Write as _;

use glam::DVec3;

use milkglass::{FaceLight, Session};

pub(super) fn csv(session: &Session, rows: &[FaceLight]) -> String {
    let mut text = String::from("face,cx,cy,cz,area,E_r,E_g,E_b,B_r,B_g,B_b,input_face");
    text += if session.state().method.estimate { ",err_r,err_g,err_b" } else { "" };
    text += if rows.iter().any(|row| row.noise.is_some()) { ",se_r,se_g,se_b" } else { "" };
    let several = session.scene().objects.len() > 1;
    text += if several { ",object\n" } else { "\n" };
    for (face, row) in rows.iter().enumerate() {
        let (c, e, b) = (row.center, row.irradiance.map(digits), row.radiosity.map(digits));
        let _ = write!(text, "{face},{:.9e},{:.9e},{:.9e},{:.9e}", c.x, c.y, c.z, row.area);
        let _ = write!(text, ",{},{},{},{},{},{}", e[0], e[1], e[2], b[0], b[1], b[2]);
        let _ = write!(text, ",{}", row.input_face);
        for x in row.estimate.iter().chain(&row.noise).flatten() {
            let _ = write!(text, ",{}", digits(*x));
        }
        if several {
            let _ = write!(text, ",{}", row.object);
        }
        text.push('\n');
    }
    text
}

/// An amount of light with the digits of an `f32`, also outside the range of one.
fn digits(x: f64) -> String {
    let single = x as f32;
    if single.is_normal() || x == 0.0 { format!("{single:e}") } else { format!("{x:.7e}") }
}

/// An amount of light as a PLY float, clamped to the largest one.
fn single(x: f64) -> f32 {
    x.min(f32::MAX.into()) as f32
}

pub(super) fn ply(session: &Session, rows: &[FaceLight]) -> String {
    let positions = session.vertices();

    // Vertex values are area-weighted means, as in stage `average`; the brightest maps to white.
    let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
    for row in rows {
        for vertex in row.triangle {
            let (sum, area) = &mut sums[vertex as usize];
            *sum += row.area * DVec3::from_array(row.radiosity);
            *area += row.area;
        }
    }
    let values: Vec<DVec3> = sums.iter().map(|&(sum, area)| if area > 0.0 { sum / area } else { sum }).collect();
    let brightest = values.iter().map(|v| v.max_element()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n\
         element face {}\nproperty list uchar int vertex_indices\n\
         property float E_r\nproperty float E_g\nproperty float E_b\n\
         property float B_r\nproperty float B_g\nproperty float B_b\n{}end_header\n",
        values.len(),
        rows.len(),
        if session.state().method.estimate {
            "property float err_r\nproperty float err_g\nproperty float err_b\n"
        } else {
            ""
        }
    );
    for (p, value) in positions.iter().zip(&values) {
        let byte = |x: f64| (milkglass::internals::view::picture::encode(x / brightest) * 255.0 + 0.5) as u8;
        let b = value.to_array();
        let [red, green, blue] = b.map(byte);
        let _ = writeln!(
            text,
            "{} {} {} {red} {green} {blue} {} {} {}",
            p.x as f32,
            p.y as f32,
            p.z as f32,
            single(b[0]),
            single(b[1]),
            single(b[2])
        );
    }
    for row in rows {
        let [a, b, c] = row.triangle;
        let _ = write!(text, "3 {a} {b} {c}");
        for x in row.irradiance.iter().chain(&row.radiosity).chain(row.estimate.iter().flatten()) {
            let _ = write!(text, " {}", single(*x));
        }
        text.push('\n');
    }
    text
}
