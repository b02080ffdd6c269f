//! `milkglass eval layered`: a flat slab of layers, on the CPU in closed form, on a device by the kernels of
//! `relief`.

use std::result::Result as Check;

use glam::DVec3;

use super::Cells;
use crate::error::{Input, Result};
use crate::gpu::Device;
use crate::layers::relief;
use crate::layers::slab::{Lamp, SlabLayer, radiance};
use crate::layout::{BufferId, Camera, Hit, LIGHT_POINT, Layer, Layering, Light, ObjectParams};
use crate::state::{DeviceState, Scope, State, Step, narrow};

/// The columns that every row needs; the columns of a layer are required only if a row has that layer.
pub(super) const COLUMNS: [&str; 9] = ["light", "layers", "lx", "ly", "lz", "intensity", "wox", "woy", "woz"];
/// Maximum number of layers in a row.
const MOST: usize = 4;
/// Samples of the march along the ray on a device.
const STEPS: u32 = 1000;
/// The share of light at which the march ends on a device.
const FAINTEST: f64 = 1e-9;

/// Largest coordinate of a point light, thickness and coefficient: squares and products must not overflow.
const FARTHEST: f64 = 1e100;

/// Normalizes a vector without overflow or underflow.
fn unit(v: DVec3) -> DVec3 {
    (v / v.abs().max_element()).normalize()
}

/// One slab.
pub(super) struct Row {
    layers: Vec<SlabLayer>,
    lamp: Lamp,
    eye: DVec3,
}

/// Reads one record.
pub(super) fn row(cells: &Cells<'_>) -> Check<Row, Input> {
    let count = cells.text("layers").parse::<usize>().ok().filter(|count| (1..=MOST).contains(count));
    let count = count.ok_or_else(|| {
        let fault = cells.fault("layers", "not a number of layers").found(format!("{:?}", cells.text("layers")));
        fault.expected(format!("a whole number from 1 to {MOST}"))
    })?;
    let layers = (1..=count).map(|number| layer(cells, number)).collect::<Check<Vec<_>, _>>()?;

    let vector = |keys: [&str; 3]| -> Check<DVec3, Input> {
        Ok(DVec3::new(cells.number(keys[0])?, cells.number(keys[1])?, cells.number(keys[2])?))
    };
    let light = vector(["lx", "ly", "lz"])?;
    if light.z <= 0.0 {
        let fault = cells.fault("lz", "the light is not above the slab").found(light.z);
        return Err(fault.expected("above 0: the slab lies under z = 0"));
    }
    let intensity = cells.at_least("intensity", 0.0)?;
    let lamp = match cells.text("light") {
        "directional" => Lamp::Directional(unit(light), intensity),
        "point" if light.abs().max_element() > FARTHEST => {
            let fault = cells.fault("light", "the light is too far away").found(light);
            return Err(fault.expected(format!("coordinates of at most {FARTHEST:e}")));
        }
        "point" => Lamp::Point(light, intensity),
        other => {
            let fault = cells.fault("light", "not a kind of light").found(format!("{other:?}"));
            return Err(fault.expected("directional or point"));
        }
    };
    let eye = vector(["wox", "woy", "woz"])?;
    if eye.z <= 0.0 {
        return Err(cells.fault("woz", "the eye is not above the slab").found(eye.z).expected("above 0"));
    }
    Ok(Row { layers, lamp, eye: unit(eye) })
}

fn layer(cells: &Cells<'_>, number: usize) -> Check<SlabLayer, Input> {
    let key = |name: &str| format!("{name}{number}");
    let column = |name: &str| {
        let key = key(name);
        match cells.header.iter().any(|known| known == key) {
            true => Ok(key),
            false => Err(cells.fault(&key, "this column is missing").expected("a column of this name")),
        }
    };
    let within = |name: &str| {
        let key = column(name)?;
        let value = cells.at_least(&key, 0.0)?;
        match value <= FARTHEST {
            true => Ok(value),
            false => Err(cells.fault(&key, "out of range").found(value).expected(format!("at most {FARTHEST:e}"))),
        }
    };
    let (thickness, sigma_s, sigma_t) = (within("thickness")?, within("sigma_s")?, within("sigma_t")?);
    if sigma_t < sigma_s {
        let fault = cells.fault(&key("sigma_t"), "extinction is less than scattering").found(sigma_t);
        return Err(fault.expected(format!("at least {}, {sigma_s}", key("sigma_s"))));
    }
    let g = cells.number(&column("g")?)?;
    if g.abs() >= 1.0 {
        return Err(cells.fault(&key("g"), "out of range").found(g).expected("above -1 and below 1"));
    }
    Ok(SlabLayer { sigma_s, sigma_t, g, thickness })
}

/// Evaluates the rows: on a device by its kernel in `f32`, on the CPU in closed form.
pub(super) fn evaluate(rows: &[Row], device: Option<&Device>) -> Result<Vec<[f64; 2]>> {
    let Some(device) = device else {
        return Ok(rows.iter().map(|row| [radiance(&row.layers, row.lamp, row.eye), 0.0]).collect());
    };
    let mut device_state = DeviceState::new(device, false)?;
    let steps = [Step { stage: &relief::STAGE, at: Scope::SCENE }];
    let mut values = Vec::with_capacity(rows.len());
    for row in rows {
        let mut state = state(row);
        device_state.upload(&state, crate::layout::BUFFER_IDS)?;
        device_state.run(&state, &steps)?;
        device_state.download(&mut state, &[BufferId::radiance])?;
        values.push([f64::from(state.data.radiance[0][0]), 0.0]);
    }
    Ok(values)
}

/// A state with one triangle of the slab, of which the only pixel shows the corner at the origin. Lengths are in
/// units of the slab's thickness.
fn state(row: &Row) -> State {
    let total: f64 = row.layers.iter().map(|layer| layer.thickness).sum();
    let unit = if total > 0.0 { total } else { 1.0 };
    let mut state = State::default();
    let data = &mut state.data;
    data.object_params = vec![ObjectParams {
        faces: 1,
        vertices: 3,
        nodes: 1,
        lights: 1,
        eta: [1.0; 3],
        turn_x: [1.0, 0.0, 0.0],
        turn_y: [0.0, 1.0, 0.0],
        turn_z: [0.0, 0.0, 1.0],
        ..ObjectParams::default()
    }];
    data.camera = vec![Camera { origin: narrow(row.eye), width: 1, height: 1, radiance: 1.0, ..Camera::default() }];
    data.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    data.triangles = vec![[0, 1, 2]];
    data.normals = vec![[0.0, 0.0, 1.0]; 3];
    data.planes = vec![[0.0, 0.0, 1.0, 0.0]; 3];
    data.hits = vec![Hit::default()];
    data.radiance = vec![[0.0; 3]];
    data.layer_lights = vec![match row.lamp {
        Lamp::Directional(toward, irradiance) => {
            Light { place: narrow(toward), color: [irradiance as f32; 3], shadow: u32::MAX, ..Light::default() }
        }
        Lamp::Point(place, intensity) => {
            let color = [(intensity / (unit * unit)) as f32; 3];
            Light { kind: LIGHT_POINT, place: narrow(place / unit), color, shadow: u32::MAX, ..Light::default() }
        }
    }];
    let least = row.layers.iter().map(|layer| layer.sigma_t).fold(f64::INFINITY, f64::min) * unit;
    data.layerings = vec![Layering {
        first_island: u32::MAX,
        layers: row.layers.len() as u32,
        size: [1, 1],
        samples: STEPS,
        deepest: (total / unit) as f32,
        reach: (-FAINTEST.ln() / least).min(1e6) as f32,
        ..Layering::default()
    }];
    let (mut depth, mut depths) = (0.0, [1e30; MOST]);
    for (layer, bottom) in row.layers.iter().zip(&mut depths) {
        depth += layer.thickness / unit;
        *bottom = depth as f32;
        let per_unit = |x: f64| [(x * unit) as f32; 3];
        let (sigma_s, sigma_t) = (per_unit(layer.sigma_s), per_unit(layer.sigma_t));
        data.layer_media.push(Layer { sigma_s, sigma_t, g: layer.g as f32 });
    }
    data.depths = vec![depths];
    state
}
