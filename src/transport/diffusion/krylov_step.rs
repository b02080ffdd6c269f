//! Stage `krylov_step`: one step of GMRES (Saad and Schultz 1986): the newest vector is made orthogonal to those before
//! it, twice, in the mean over the object's area, and scaled to length 1; the small system gains a column, which
//! rotations make triangular. The last entry of its right-hand side is the residual's norm. Each channel is solved by
//! itself. At a start from a solution, the second vector is the source term, of which only the norm is taken.

use crate::error::Result;
use crate::layout::{
    BufferId, Buffers, MOST_STEPS, SMALL_COSINES, SMALL_MATRIX, SMALL_NORMS, SMALL_PRODUCTS, SMALL_RIGHT, SMALL_SINES,
};
use crate::state::{Granularity, Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "krylov_step",
    about: "a step of GMRES: orthogonalises the newest vector, and finds the residual's norm",
    equation: "w = M v - sum <M v, v_i> v_i, v' = w / |w|, rotations of the small system; Saad and Schultz 1986",
    writes: &[
        (BufferId::krylov, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-4 }),
        (BufferId::small_system, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
    ],
    reason: "sums over all triangles; a vector less its projections on the others may be a hundredth of itself",
    granularity: Granularity::Iteration,
    ..super::stage(cpu, gpu)
};

/// The mean over the area of the product of two vectors, in one channel.
fn mean(data: &Buffers, [a, b]: [usize; 2], c: usize) -> f64 {
    let faces = data.triangles.len();
    let term = |face: usize| {
        let area = f64::from(data.clusters[data.leaves[face] as usize].area);
        area * f64::from(data.krylov[a * faces + face][c]) * f64::from(data.krylov[b * faces + face][c])
    };
    (0..faces).map(term).sum::<f64>() / f64::from(data.clusters[0].area).max(1e-37)
}

fn cpu(state: &mut State, at: Scope) {
    let (newest, warm, data) = (at.chunk, state.method.warm, &mut state.data);
    let faces = data.triangles.len();
    for c in 0..3 {
        let mut column = vec![0.0; newest];
        for _ in 0..2 {
            let products: Vec<f64> = (0..newest).map(|k| mean(data, [k, newest], c)).collect();
            for face in 0..faces {
                let shares: f64 = (0..newest).map(|k| products[k] * f64::from(data.krylov[k * faces + face][c])).sum();
                let value = &mut data.krylov[newest * faces + face][c];
                *value = (f64::from(*value) - shares) as f32;
            }
            for (k, product) in products.into_iter().enumerate() {
                column[k] += product;
                data.small_system[SMALL_PRODUCTS + k][c] = product as f32;
            }
        }
        let square = mean(data, [newest; 2], c);
        data.small_system[SMALL_PRODUCTS + newest][c] = square as f32;
        rotate(data, newest, c, &mut column, square.sqrt());
        if warm && newest == 0 {
            let whole = mean(data, [1; 2], c);
            data.small_system[SMALL_PRODUCTS + 1][c] = whole as f32;
            data.small_system[SMALL_NORMS][c] = whole.sqrt() as f32;
        }
        let by = if square > 1e-37 { 1.0 / square.sqrt() } else { 0.0 };
        for value in &mut data.krylov[newest * faces..][..faces] {
            value[c] = (f64::from(value[c]) * by) as f32;
        }
    }
}

/// Makes the newest column triangular; `size` is its last entry.
fn rotate(data: &mut Buffers, newest: usize, c: usize, column: &mut [f64], size: f64) {
    let small = &mut data.small_system;
    if newest == 0 {
        for place in [SMALL_RIGHT, SMALL_NORMS, SMALL_NORMS + 1] {
            small[place][c] = size as f32;
        }
        return;
    }
    let at = |small: &[[f32; 3]], place: usize| f64::from(small[place][c]);
    for k in 0..newest - 1 {
        let (cos, sin) = (at(small, SMALL_COSINES + k), at(small, SMALL_SINES + k));
        (column[k], column[k + 1]) = (cos * column[k] + sin * column[k + 1], cos * column[k + 1] - sin * column[k]);
    }
    let last = newest - 1;
    let radius = column[last].hypot(size);
    let (cos, sin) = if radius > 1e-37 { (column[last] / radius, size / radius) } else { (1.0, 0.0) };
    column[last] = radius;
    let right = at(small, SMALL_RIGHT + last);
    let first = SMALL_MATRIX + last * (MOST_STEPS + 1);
    for (k, value) in column.iter().chain([&size]).enumerate() {
        small[first + k][c] = *value as f32;
    }
    for (place, value) in [
        (SMALL_COSINES + last, cos),
        (SMALL_SINES + last, sin),
        (SMALL_RIGHT + last, cos * right),
        (SMALL_RIGHT + newest, -sin * right),
        (SMALL_NORMS + 1, (sin * right).abs()),
    ] {
        small[place][c] = value as f32;
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let (newest, faces) = (pass.at.chunk as u32, pass.object().count.faces);
    let push = bytemuck::bytes_of(&newest).to_vec();
    if newest > 0 {
        for round in 0..2u32 {
            pass.dispatch_groups("products", &[round], bytemuck::bytes_of(&[newest, 0]), newest as usize)?;
            pass.dispatch(Some("subtract"), &[], &push, faces)?;
        }
    }
    let warm = pass.state.method.warm;
    pass.dispatch_groups("products", &[0], bytemuck::bytes_of(&[newest, newest]), 1)?;
    if warm && newest == 0 {
        pass.dispatch_groups("products", &[0], bytemuck::bytes_of(&[1u32, 1]), 1)?;
    }
    pass.dispatch(Some("rotate"), &[u32::from(warm)], &push, 1)?;
    pass.dispatch(Some("scale"), &[], &push, faces)
}
