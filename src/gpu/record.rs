//! Recording a frame: dispatches, the barriers they need, a label and two timestamps per stage, one submission.

use std::collections::BTreeSet;
use std::ffi::CString;
use std::rc::Rc;

use ash::vk;
use ash::vk::Handle as _;

use super::bind::{Binding, Sets};
use super::call::vk_call;
use super::count;
use super::kernel::Kernel;
use super::logical_device::LogicalDevice;
use super::memory::Buffer;
use crate::error::{Error, Result};

/// How long one labelled part of a frame took.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The label.
    pub name: String,
    /// Time on the device, milliseconds; not a number where the device has no timestamps.
    pub milliseconds: f64,
    /// When it began, milliseconds after the first part of its submission; not a number where the device has no
    /// timestamps.
    pub start: f64,
    /// Its dispatches; 0 for what the host does.
    pub dispatches: usize,
    /// The barriers recorded before them.
    pub barriers: usize,
}

/// How large a dispatch is.
#[derive(Clone, Copy)]
pub enum Work<'a> {
    /// This many invocations, rounded up to whole groups.
    Invocations(u64),
    /// This many groups in each dimension.
    Grid([u32; 3]),
    /// As many groups as three numbers in a buffer say: an indirect dispatch.
    Groups {
        /// The buffer.
        buffer: &'a Buffer,
        /// The first byte of the three numbers.
        offset: u64,
    },
}

/// A frame being recorded.
pub struct Recorder {
    device: LogicalDevice,
    commands: vk::CommandBuffer,
    sets: Sets,
    queries: vk::QueryPool,
    /// The names of the parts begun so far.
    names: Vec<String>,
    /// The dispatches and barriers of each.
    counts: Vec<[usize; 2]>,
    /// How many parts the queries suffice for.
    timed_parts: usize,
    /// What has to live until the submission has been waited for.
    kernels: Vec<Rc<Kernel>>,
    /// Buffers read since the last barrier, by handle.
    read: BTreeSet<u64>,
    /// Buffers written since the last barrier, by handle.
    written: BTreeSet<u64>,
}

impl Recorder {
    /// Begins a frame of at most `parts` labelled parts.
    pub fn new(device: &LogicalDevice, parts: usize) -> Result<Self> {
        let doing = "recording a frame";
        let commands = device.begin(doing)?;
        let mut recorder = Self {
            device: device.clone(),
            commands,
            sets: Sets::new(device),
            queries: vk::QueryPool::null(),
            names: Vec::new(),
            counts: Vec::new(),
            timed_parts: 0,
            kernels: Vec::new(),
            read: BTreeSet::new(),
            written: BTreeSet::new(),
        };
        if device.limits().timestamp_period > 0.0 && parts > 0 {
            let count = u32::try_from(2 * parts).unwrap_or(u32::MAX);
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(count);
            // SAFETY: the device is alive; the pool is freed with the recorder.
            unsafe {
                recorder.queries = vk_call("vkCreateQueryPool", doing, || device.raw().create_query_pool(&info, None))?;
                device.raw().cmd_reset_query_pool(commands, recorder.queries, 0, count);
            }
            recorder.timed_parts = parts;
        }
        Ok(recorder)
    }

    /// Records what `body` records as a part of this name: within a debug label, and with a timestamp before and after.
    pub fn part(&mut self, name: &str, body: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let raw = self.device.raw().clone();
        let index = self.names.len();
        let timed = index < self.timed_parts;
        self.names.push(name.to_string());
        self.counts.push([0; 2]);
        let debug = self.device.debug().cloned();
        // SAFETY: the command buffer is recording; both queries lie within the pool.
        unsafe {
            if let (Some(debug), Ok(name)) = (&debug, CString::new(name)) {
                let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
                debug.cmd_begin_debug_utils_label(self.commands, &label);
            }
            if timed {
                let stage = vk::PipelineStageFlags::COMPUTE_SHADER;
                raw.cmd_write_timestamp(self.commands, stage, self.queries, 2 * index as u32);
            }
        }
        let done = body(self);
        // SAFETY: as above.
        unsafe {
            if timed {
                let stage = vk::PipelineStageFlags::COMPUTE_SHADER;
                raw.cmd_write_timestamp(self.commands, stage, self.queries, 2 * index as u32 + 1);
            }
            if let Some(debug) = &debug {
                debug.cmd_end_debug_utils_label(self.commands);
            }
        }
        done
    }

    /// Records a dispatch of a kernel, after a barrier where it depends on an earlier dispatch.
    pub fn dispatch(
        &mut self,
        kernel: &Rc<Kernel>,
        bindings: &[Binding<'_>],
        push: &[u8],
        work: Work<'_>,
    ) -> Result<()> {
        let doing = || format!("recording kernel {}", kernel.name);
        if matches!(work, Work::Invocations(0)) || matches!(work, Work::Grid(groups) if groups.contains(&0)) {
            return Ok(());
        }
        if push.len() != kernel.push_bytes as usize {
            let (given, takes) = (push.len(), kernel.push_bytes);
            return Err(Error::device(doing(), format!("{given} bytes of push constants given, it takes {takes}")));
        }
        let limit = self.device.limits().binding_bytes;
        for binding in bindings {
            if binding.size > limit {
                let (name, size) = (binding.buffer.name(), binding.size);
                return Err(Error::device(
                    doing(),
                    format!(
                        "buffer {name} has {size} bytes, the device binds at most {limit}; use fewer triangles or pixels, or \
                         --device cpu"
                    ),
                ));
            }
        }
        // A kernel that counts has a buffer of its own for its counters.
        let mut bindings = bindings.to_vec();
        if let Some(meter) = &kernel.meter {
            let (number, buffer) = (count::BINDING, &meter.counters);
            bindings.push(Binding { number, buffer, offset: 0, size: buffer.size() });
        }
        let bindings = &bindings;
        let set = self.sets.get(kernel, bindings)?;
        self.order(kernel, bindings, work);

        let direct = match work {
            Work::Invocations(count) => kernel.grid(count),
            Work::Grid(groups) => groups,
            Work::Groups { .. } => [0; 3],
        };
        let most = self.device.limits().groups;
        if direct[0] > most[0] || direct[1] > most[1] {
            let what = format!(
                "it takes {} x {} groups, the device dispatches at most {} x {}",
                direct[0], direct[1], most[0], most[1]
            );
            return Err(Error::device(doing(), what));
        }
        let raw = self.device.raw();
        // SAFETY: kernel, set and buffers live until the submission has been waited for.
        unsafe {
            raw.cmd_bind_pipeline(self.commands, vk::PipelineBindPoint::COMPUTE, kernel.pipeline);
            raw.cmd_bind_descriptor_sets(self.commands, vk::PipelineBindPoint::COMPUTE, kernel.layout, 0, &[set], &[]);
            if !push.is_empty() {
                raw.cmd_push_constants(self.commands, kernel.layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            }
            match work {
                Work::Invocations(_) | Work::Grid(_) => {
                    raw.cmd_dispatch(self.commands, direct[0], direct[1], direct[2])
                }
                Work::Groups { buffer, offset } => raw.cmd_dispatch_indirect(self.commands, buffer.raw, offset),
            }
        }
        self.kernels.push(kernel.clone());
        if let Some([dispatches, _]) = self.counts.last_mut() {
            *dispatches += 1;
        }
        Ok(())
    }

    /// Records a barrier if this dispatch reads what was written since the last barrier, or writes what was read or
    /// written since then.
    fn order(&mut self, kernel: &Kernel, bindings: &[Binding<'_>], work: Work<'_>) {
        let uses: Vec<_> = kernel
            .accesses
            .iter()
            .filter_map(|access| {
                let binding = bindings.iter().find(|b| b.number == access.binding)?;
                Some((binding.buffer.raw.as_raw(), access))
            })
            .collect();
        let counted = match work {
            Work::Groups { buffer, .. } => Some(buffer.raw.as_raw()),
            Work::Invocations(_) | Work::Grid(_) => None,
        };
        let hazard = counted.is_some_and(|buffer| self.written.contains(&buffer))
            || uses
                .iter()
                .any(|(buffer, access)| self.written.contains(buffer) || (access.writes && self.read.contains(buffer)));
        if hazard {
            let all =
                vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE | vk::AccessFlags::INDIRECT_COMMAND_READ;
            let barrier =
                [vk::MemoryBarrier::default().src_access_mask(vk::AccessFlags::SHADER_WRITE).dst_access_mask(all)];
            let stage = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::DRAW_INDIRECT;
            let (raw, flags) = (self.device.raw(), vk::DependencyFlags::empty());
            // SAFETY: the command buffer is recording.
            unsafe { raw.cmd_pipeline_barrier(self.commands, stage, stage, flags, &barrier, &[], &[]) };
            if let Some([_, barriers]) = self.counts.last_mut() {
                *barriers += 1;
            }
            self.read.clear();
            self.written.clear();
        }
        self.read.extend(counted);
        for (buffer, access) in uses {
            if access.reads {
                self.read.insert(buffer);
            }
            if access.writes {
                self.written.insert(buffer);
            }
        }
    }

    /// Submits the frame, waits for it, and returns the time of each part on the device.
    pub fn submit(self) -> Result<Vec<Timing>> {
        let mut stages = self.names.clone();
        stages.dedup();
        let dispatches: usize = self.counts.iter().map(|[dispatches, _]| dispatches).sum();
        let doing = format!("running a frame ({}; {dispatches} dispatches)", stages.join(", "));
        let raw = self.device.raw();
        vk_call("vkEndCommandBuffer", &doing, || {
            // SAFETY: the command buffer is complete; what it uses is owned by `self` or borrowed by the caller.
            unsafe { raw.end_command_buffer(self.commands) }
        })?;
        self.device.submit(self.commands, &doing)?;
        let mut ticks = vec![0u64; 2 * self.names.len().min(self.timed_parts)];
        if !ticks.is_empty() {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            vk_call("vkGetQueryPoolResults", &doing, || {
                // SAFETY: every query of the range was written by the submission.
                unsafe { raw.get_query_pool_results(self.queries, 0, &mut ticks, flags) }
            })?;
        }
        let period = f64::from(self.device.limits().timestamp_period);
        let mask = self.device.limits().timestamp_mask;
        let between = |from: Option<&u64>, to: Option<&u64>| match (from, to) {
            (Some(from), Some(to)) => (to.wrapping_sub(*from) & mask) as f64 * period * 1e-6,
            _ => f64::NAN,
        };
        let timing = |(k, name): (usize, &String)| Timing {
            name: name.clone(),
            milliseconds: between(ticks.get(2 * k), ticks.get(2 * k + 1)),
            start: between(ticks.first(), ticks.get(2 * k)),
            dispatches: self.counts[k][0],
            barriers: self.counts[k][1],
        };
        Ok(self.names.iter().enumerate().map(timing).collect())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if !self.device.finished() {
            return;
        }
        self.device.discard(self.commands);
        // SAFETY: a submitted frame has been waited for; one that was not submitted is not in use.
        unsafe { self.device.raw().destroy_query_pool(self.queries, None) };
    }
}
