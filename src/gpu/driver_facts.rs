//! What a driver says of pipelines and of its counters, where it has the extensions for it.

use std::ffi::CStr;

use ash::{khr, vk};

use super::call::vk_call;
use super::device::Device;
use super::kernel::Kernel;
use super::logical_device::LogicalDevice;
use crate::error::Result;

/// The extension for statistics of pipelines.
pub const STATISTICS: &CStr = khr::pipeline_executable_properties::NAME;
/// The extension for counters of the hardware.
pub const COUNTERS: &CStr = khr::performance_query::NAME;

/// What the driver's compiler says of a pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistic {
    /// What it counts, in the driver's words: `Register Count`.
    pub name: String,
    /// The value.
    pub value: f64,
}

impl Device {
    /// Whether the driver offers an extension.
    pub fn offers(&self, extension: &CStr) -> Result<bool> {
        let (instance, physical) = (&self.instance().0.raw, self.adapter().physical);
        let offered = vk_call("vkEnumerateDeviceExtensionProperties", "listing the driver's extensions", || {
            // SAFETY: the adapter is of this instance, which is alive.
            unsafe { instance.enumerate_device_extension_properties(physical) }
        })?;
        Ok(offered.iter().any(|known| known.extension_name_as_c_str().is_ok_and(|name| name == extension)))
    }

    /// The names of the hardware's counters that the queue offers; empty without the extension for them.
    pub fn counter_names(&self) -> Result<Vec<String>> {
        if !self.offers(COUNTERS)? {
            return Ok(Vec::new());
        }
        let (adapter, name) = (self.adapter(), "vkEnumeratePhysicalDeviceQueueFamilyPerformanceQueryCountersKHR");
        let (physical, family, doing) = (adapter.physical, adapter.queue_family, "listing the hardware's counters");
        let functions = khr::performance_query::Instance::new(&self.instance().0.entry, &self.instance().0.raw);
        // SAFETY: the driver offers the extension; both lists are as long as it says.
        unsafe {
            let count = vk_call(name, doing, || {
                functions.enumerate_physical_device_queue_family_performance_query_counters_len(physical, family)
            })?;
            let mut counters = vec![vk::PerformanceCounterKHR::default(); count];
            let mut texts = vec![vk::PerformanceCounterDescriptionKHR::default(); count];
            vk_call(name, doing, || {
                functions.enumerate_physical_device_queue_family_performance_query_counters(
                    physical,
                    family,
                    &mut counters,
                    &mut texts,
                )
            })?;
            Ok(texts.iter().map(|text| words(text.name_as_c_str())).collect())
        }
    }
}

impl Kernel {
    /// What the driver's compiler says of its pipeline: see [`Device::with_statistics`].
    pub(crate) fn statistics(&self) -> Result<Vec<Statistic>> {
        let device: &LogicalDevice = &self.device;
        if !device.extras().statistics || self.pipeline == vk::Pipeline::null() {
            return Ok(Vec::new());
        }
        let functions = khr::pipeline_executable_properties::Device::new(&device.instance().0.raw, device.raw());
        let (pipeline, doing) = (self.pipeline, format!("asking the driver about kernel {}", self.name));
        let (mut found, name) = (Vec::new(), "vkGetPipelineExecutablePropertiesKHR");
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline was created with the flag for statistics, on a device with the extension.
        let executables = vk_call(name, &doing, || unsafe { functions.get_pipeline_executable_properties(&info) })?;
        for index in (0..).take(executables.len()) {
            let info = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline).executable_index(index);
            let name = "vkGetPipelineExecutableStatisticsKHR";
            // SAFETY: as above; the pipeline has an executable of this index.
            let known = vk_call(name, &doing, || unsafe { functions.get_pipeline_executable_statistics(&info) })?;
            found.extend(
                known
                    .iter()
                    .map(|statistic| Statistic { name: words(statistic.name_as_c_str()), value: value(statistic) }),
            );
        }
        Ok(found)
    }

    /// The texts that the driver's compiler made of it, down to the machine's instructions: their names and themselves.
    /// None without [`Device::compiler`].
    #[cfg(feature = "cli")]
    pub(crate) fn code(&self) -> Result<Vec<(String, String)>> {
        let device: &LogicalDevice = &self.device;
        if !device.extras().code {
            return Ok(Vec::new());
        }
        let functions = khr::pipeline_executable_properties::Device::new(&device.instance().0.raw, device.raw());
        let info = vk::PipelineExecutableInfoKHR::default().pipeline(self.pipeline);
        let call = functions.fp().get_pipeline_executable_internal_representations_khr;
        let (name, doing) = ("vkGetPipelineExecutableInternalRepresentationsKHR", format!("asking for {}", self.name));
        // The first call counts the texts, the second tells their lengths, the third writes them.
        let mut count = 0;
        let ask = |count: &mut u32, texts: *mut vk::PipelineExecutableInternalRepresentationKHR<'_>| {
            // SAFETY: the pipeline, which has an executable of index 0, was created with the flag for this, on a device
            // with the extension; `texts` is null or has `count` elements, whose `data` are null or `data_size` long.
            vk_call(name, &doing, || unsafe { call(device.raw().handle(), &info, count, texts).result() })
        };
        ask(&mut count, std::ptr::null_mut())?;
        let mut texts = vec![vk::PipelineExecutableInternalRepresentationKHR::default(); count as usize];
        ask(&mut count, texts.as_mut_ptr())?;
        let mut held: Vec<Vec<u8>> = texts.iter().map(|text| vec![0; text.data_size]).collect();
        for (text, bytes) in texts.iter_mut().zip(&mut held) {
            text.p_data = bytes.as_mut_ptr().cast();
        }
        ask(&mut count, texts.as_mut_ptr())?;
        let is_text = |text: &vk::PipelineExecutableInternalRepresentationKHR<'_>| text.is_text == vk::TRUE;
        let texts = texts.iter().zip(&held).filter(|(text, _)| is_text(text));
        Ok(texts
            .map(|(text, bytes)| {
                let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
                (words(text.name_as_c_str()), String::from_utf8_lossy(&bytes[..end]).into_owned())
            })
            .collect())
    }
}

/// A text that the driver wrote into an array; empty where it has no end.
fn words(text: std::result::Result<&CStr, impl std::error::Error>) -> String {
    text.map_or_else(|_| String::new(), |text| text.to_string_lossy().into_owned())
}

/// A statistic's value as a number.
fn value(statistic: &vk::PipelineExecutableStatisticKHR<'_>) -> f64 {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    let value = statistic.value;
    // SAFETY: the format says which field is set.
    unsafe {
        match statistic.format {
            Format::BOOL32 => f64::from(value.b32),
            Format::INT64 => value.i64 as f64,
            Format::UINT64 => value.u64 as f64,
            _ => value.f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statistic_is_read_by_its_format() {
        use vk::{PipelineExecutableStatisticFormatKHR as Format, PipelineExecutableStatisticValueKHR as Value};
        for (format, set, right) in [
            (Format::UINT64, Value { u64: 32 }, 32.0),
            (Format::INT64, Value { i64: -3 }, -3.0),
            (Format::FLOAT64, Value { f64: 0.5 }, 0.5),
            (Format::BOOL32, Value { b32: 1 }, 1.0),
        ] {
            let statistic = vk::PipelineExecutableStatisticKHR { format, value: set, ..Default::default() };
            assert_eq!(value(&statistic), right, "{format:?}");
        }
    }
}
