//! What drags and the wheel do.

use winit::event::{Modifiers, MouseButton};

use super::keys::{Action, ZOOM};

/// Degrees per pixel of a drag.
const DRAG: f64 = 0.4;
/// How near to a handle a drag of it begins, pixels.
const NEAR: f64 = 10.0;

/// What a drag does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drag {
    Orbit,
    Pan,
    Light,
    /// A drag of a light's handle, which shifts the light.
    Handle,
}

impl Drag {
    /// The drag that begins with this button.
    pub(super) fn of(button: MouseButton, modifiers: Modifiers) -> Option<Self> {
        let state = modifiers.state();
        match button {
            MouseButton::Left if state.control_key() => Some(Self::Light),
            MouseButton::Left if state.shift_key() => Some(Self::Pan),
            MouseButton::Left => Some(Self::Orbit),
            MouseButton::Middle => Some(Self::Pan),
            MouseButton::Right => Some(Self::Light),
            _ => None,
        }
    }

    /// What a movement by pixels to the right and downwards does in a picture of this height: things follow the
    /// pointer.
    pub(super) fn moved(self, right: f64, down: f64, height: u32) -> Action {
        let height = f64::from(height.max(1));
        match self {
            Self::Orbit => Action::Orbit(-DRAG * right, DRAG * down),
            Self::Pan => Action::Pan(-right / height, down / height),
            Self::Light => Action::Light(DRAG * right, -DRAG * down),
            Self::Handle => Action::Shift(right / height, -down / height),
        }
    }
}

/// What a turn of the wheel by this many lines does; above 0 is upwards.
pub(super) fn wheel(lines: f64) -> Action {
    Action::Zoom(ZOOM.powf(lines))
}

/// The light whose handle is at a pixel: the nearest one.
pub(super) fn handle_at(handles: &[Option<[f64; 2]>], at: [f64; 2]) -> Option<usize> {
    let away = |handle: &[f64; 2]| (handle[0] - at[0]).hypot(handle[1] - at[1]);
    let near = handles.iter().enumerate().filter_map(|(light, handle)| Some((light, away(handle.as_ref()?))));
    near.filter(|(_, away)| *away <= NEAR).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(light, _)| light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_handle_is_dragged() {
        let handles = [Some([10.0, 10.0]), None, Some([16.0, 10.0]), Some([90.0, 90.0])];
        assert_eq!(handle_at(&handles, [12.0, 10.0]), Some(0));
        assert_eq!(handle_at(&handles, [15.0, 11.0]), Some(2));
        assert_eq!(handle_at(&handles, [50.0, 50.0]), None);
        assert_eq!(Drag::Handle.moved(30.0, 60.0, 300), Action::Shift(0.1, -0.2));
    }
}
