//! The Vulkan instance, its validation messages, and the list of its adapters.

use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex};

use ash::{ext, khr, vk};

use super::adapter::Adapter;
use super::call::vk_call;
use super::faults::altered;
use crate::error::{Error, Result};

/// The layer that checks calls.
const VALIDATION: &CStr = c"VK_LAYER_KHRONOS_validation";

/// A loaded Vulkan library. Clones share it.
#[derive(Clone)]
pub struct Instance(pub(super) Arc<Inner>);

pub(super) struct Inner {
    pub(super) raw: ash::Instance,
    pub(super) debug: Option<ext::debug_utils::Instance>,
    messenger: vk::DebugUtilsMessengerEXT,
    messages: Box<Mutex<Vec<String>>>,
    /// Whether its devices can show pictures in windows.
    pub(super) presents: bool,
    pub(super) entry: ash::Entry,
}

/// Keeps a message of the validation layer.
unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `user` is the boxed list of `Inner`, which outlives the messenger; the layer passes valid strings.
    unsafe {
        let list = &*user.cast::<Mutex<Vec<String>>>();
        let text = (*data).p_message;
        if !text.is_null()
            && let Ok(mut list) = list.lock()
        {
            list.push(format!("{severity:?}: {}", CStr::from_ptr(text).to_string_lossy()));
        }
    }
    vk::FALSE
}

impl Inner {
    /// Keeps the validation layer's messages from now on.
    fn listen(&mut self) -> Result<()> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Kind};
        let Some(debug) = &self.debug else { return Ok(()) };
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            .message_type(Kind::VALIDATION | Kind::GENERAL)
            .pfn_user_callback(Some(on_message))
            .user_data(std::ptr::from_ref(&*self.messages).cast_mut().cast());
        self.messenger = vk_call("vkCreateDebugUtilsMessengerEXT", "listening to the validation layer", || {
            // SAFETY: the callback's data lives in the box of `self`, freed after the messenger.
            unsafe { debug.create_debug_utils_messenger(&info, None) }
        })?;
        Ok(())
    }
}

impl Instance {
    /// Loads Vulkan; with `validation`, the Khronos layer with synchronization validation, whose messages are kept.
    pub fn open(validation: bool) -> Result<Self> {
        Self::with_extensions(validation, &[])
    }

    /// The same, with the extensions that surfaces of windows need; its devices then have swapchains.
    pub(super) fn with_extensions(validation: bool, surface: &[*const c_char]) -> Result<Self> {
        let doing = "loading Vulkan";
        // SAFETY: the library that is loaded is the system's Vulkan loader.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| {
            Error::device(
                doing,
                format!(
                    "no Vulkan loader; install one (Debian: libvulkan1, mesa-vulkan-drivers), or use --device cpu: {e}"
                ),
            )
        })?;
        let application =
            vk::ApplicationInfo::default().application_name(c"milkglass").api_version(vk::API_VERSION_1_2);
        let mut extensions = surface.to_vec();
        let mut layers = Vec::new();
        // Loaders fail here where no driver can be loaded; the error of the next call explains that better.
        let offered = vk_call("vkEnumerateInstanceExtensionProperties", doing, || {
            // SAFETY: a plain query on a loaded entry.
            unsafe { entry.enumerate_instance_extension_properties(None) }
        })
        .unwrap_or_default();
        let offers =
            |wanted: &CStr| offered.iter().any(|e| e.extension_name_as_c_str().is_ok_and(|name| name == wanted));
        let labels = offers(ext::debug_utils::NAME);
        if labels || validation {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        // Else loaders do not list drivers of a part of Vulkan, such as MoltenVK.
        let mut flags = vk::InstanceCreateFlags::empty();
        if offers(khr::portability_enumeration::NAME) {
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        let checks = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&checks);
        let mut info = vk::InstanceCreateInfo::default().flags(flags).application_info(&application);
        if validation {
            layers.push(VALIDATION.as_ptr());
            extensions.push(ext::validation_features::NAME.as_ptr());
            info = info.push_next(&mut features);
        }
        let info = info.enabled_extension_names(&extensions).enabled_layer_names(&layers);
        let raw = vk_call("vkCreateInstance", "starting Vulkan", || {
            // SAFETY: `info` and all it points to live through the call.
            unsafe { entry.create_instance(&info, None) }
        })?;
        let debug = (labels || validation).then(|| ext::debug_utils::Instance::new(&entry, &raw));
        let mut inner = Inner {
            raw,
            debug,
            messenger: vk::DebugUtilsMessengerEXT::null(),
            messages: Box::default(),
            presents: !surface.is_empty(),
            entry,
        };
        if validation {
            inner.listen()?;
        }
        Ok(Self(Arc::new(inner)))
    }

    /// The version of the validation layer, if it watches.
    #[must_use]
    pub fn layer(&self) -> Option<String> {
        // SAFETY: a plain query on a loaded entry.
        let layers = unsafe { self.0.entry.enumerate_instance_layer_properties() }.unwrap_or_default();
        let found = layers.iter().find(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION));
        let version = |packed: u32| {
            let [major, minor] = [vk::api_version_major(packed), vk::api_version_minor(packed)];
            format!("{major}.{minor}.{}", vk::api_version_patch(packed))
        };
        found.filter(|_| self.validates()).map(|layer| version(layer.spec_version))
    }

    /// Whether the validation layer watches it.
    pub(super) fn validates(&self) -> bool {
        self.0.messenger != vk::DebugUtilsMessengerEXT::null()
    }

    /// Takes the validation messages that have come since the last call.
    pub fn take_messages(&self) -> Vec<String> {
        self.0.messages.lock().map(|mut list| std::mem::take(&mut *list)).unwrap_or_default()
    }

    /// Every adapter, in the loader's order.
    pub fn adapters(&self) -> Result<Vec<Adapter>> {
        let list = vk_call("vkEnumeratePhysicalDevices", "listing Vulkan devices", || {
            // SAFETY: the instance is alive.
            unsafe { self.0.raw.enumerate_physical_devices() }
        })?;
        let query = |physical| altered(Adapter::query(&self.0.entry, &self.0.raw, physical));
        let mut found: Vec<_> = list.into_iter().map(query).collect();
        Adapter::tell_apart(&mut found);
        Ok(found)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: devices hold a clone of the instance, so none is left; the messenger goes before its instance.
        unsafe {
            if let Some(debug) = &self.debug
                && self.messenger != vk::DebugUtilsMessengerEXT::null()
            {
                debug.destroy_debug_utils_messenger(self.messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}
