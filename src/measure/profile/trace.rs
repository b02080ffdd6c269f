//! Timed frames as a trace for Chrome or Perfetto.

use serde_json::{Value, json};

use super::{Frame, Profile};

/// Frames of a scene as trace events, in microseconds: frames on one track, steps on another, and counters: memory,
/// links, and what `rates` returns for a stage's name. Where the clocks of host and device are not aligned, the steps
/// are shifted such that the last one ends with its frame. `otherData.clocks` says which it is.
pub fn trace<'a>(
    [scene, device, driver]: [&str; 3],
    frames: impl IntoIterator<Item = &'a Frame>,
    rates: &dyn Fn(&str) -> Vec<(&'static str, f64)>,
) -> Value {
    let track =
        |id: u32, name: &str| json!({"ph": "M", "name": "thread_name", "pid": 1, "tid": id, "args": {"name": name}});
    let mut events = vec![
        json!({"ph": "M", "name": "process_name", "pid": 1, "args": {"name": format!("milkglass {scene}")}}),
        track(1, "host"),
        track(2, device),
    ];
    let mut off = Some(0.0);
    for (number, frame) in frames.into_iter().enumerate() {
        off = off.zip(frame.aligned).map(|(known, off)| f64::max(known, off));
        let (start, length) = (frame.start, frame.wall);
        let event = |name: &str, id: u32, at: f64, length: f64| json!({"ph": "X", "name": name, "pid": 1, "tid": id, "ts": at * 1e3, "dur": length * 1e3, "args": {"frame": number}});
        events.push(event("frame", 1, start, length));
        // Steps without a start time follow one another.
        let (mut placed, mut next) = (Vec::new(), 0.0);
        for step in frame.steps.iter().filter(|step| step.milliseconds.is_finite()) {
            let at = if step.start.is_finite() { f64::max(step.start, next) } else { next };
            placed.push((step, at));
            next = at + step.milliseconds;
        }
        let late = if frame.aligned.is_some() { 0.0 } else { (length - next).max(0.0) };
        let counter = |name: &str, key: &str, at: f64, value: f64| json!({"ph": "C", "name": name, "pid": 1, "ts": at * 1e3, "args": json!({ key: value })});
        if frame.memory > 0 {
            events.push(counter("memory, MB", "MB", start, frame.memory as f64 * 1e-6));
        }
        events.extend(frame.links.map(|links| counter("links", "links", start, links as f64)));
        for (step, at) in placed {
            let begin = start + late + at;
            events.push(event(&step.name, 2, begin, step.milliseconds));
            for (name, rate) in rates(&step.name) {
                for (at, rate) in [(begin, rate), (begin + step.milliseconds, 0.0)] {
                    events.push(counter(name, name, at, rate));
                }
            }
        }
    }
    let clocks = match off {
        Some(off) => {
            format!("calibrated timestamps: the device's times are known by the host's to {:.1} us", off * 1e3)
        }
        None => "not aligned: the last step of each frame ends with the frame".to_string(),
    };
    json!({"displayTimeUnit": "ms", "traceEvents": events,
           "otherData": {"device": device, "driver": driver, "clocks": clocks}})
}

impl Profile {
    /// The timed frames as [`trace`] events.
    pub fn trace(&self) -> Value {
        trace([&self.scene, &self.device, &self.driver], &self.trace, &|stage| self.rates_of(stage))
    }

    /// The mean rates of a stage: billions of additions and multiplications per second, and of bytes read and written;
    /// none if its work was not counted.
    fn rates_of(&self, stage: &str) -> Vec<(&'static str, f64)> {
        let row = self.rows.iter().find(|row| row.stage == stage);
        let Some((work, seconds)) = row.and_then(|row| Some((row.work?, row.seconds()?))) else { return Vec::new() };
        let rate = |count: u64| count as f64 / seconds * 1e-9;
        vec![("Gflop/s", rate(work.flops)), ("GB/s", rate(work.read + work.written))]
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::gpu::Timing;

    #[test]
    fn steps_lie_where_the_clocks_say_or_end_with_their_frame() {
        let begin = Instant::now().checked_sub(Duration::from_millis(100)).unwrap();
        let within = Duration::from_micros(3);
        let step = |name: &str, start: f64, at: Option<u64>| Timing {
            name: name.into(),
            milliseconds: 10.0,
            start,
            began: at.map(|at| (begin + Duration::from_millis(at), within)),
            ..Timing::default()
        };
        let starts = |steps: Vec<Timing>| {
            let frame = Frame::since(begin, steps);
            let found = trace(["scene", "device", "driver"], [&frame], &|_| Vec::new());
            let events = found["traceEvents"].as_array().unwrap().iter();
            let starts: Vec<f64> = events
                .filter(|event| event["tid"] == 2)
                .filter_map(|event| Some(event["ts"].as_f64()? * 1e-3))
                .collect();
            (starts, frame.wall, found["otherData"]["clocks"].as_str().unwrap().to_string())
        };
        // Two submissions, of which the second waits for the host.
        let (found, _, clocks) = starts(vec![step("a", 0.0, Some(5)), step("b", 0.0, Some(40))]);
        assert!(clocks.ends_with(" 3.0 us") && (found[0] - 5.0).abs() + (found[1] - 40.0).abs() < 1e-6, "{found:?}");
        for unknown in [None, Some(40)] {
            let (found, wall, clocks) = starts(vec![step("a", 0.0, None), step("b", 10.0, unknown)]);
            assert!(clocks.starts_with("not aligned") && (found[1] + 10.0 - wall).abs() < 1e-6, "{found:?} {wall}");
        }
    }
}
