//! A device as the rest of the program uses it: a logical device, and the kernels made for it.

use std::ops::Deref;
use std::rc::Rc;

use super::adapter::{Adapter, Limits};
use super::choices::Choices;
use super::driver_facts::STATISTICS;
use super::execution::verify_execution;
use super::extras::{Extras, Features, needed};
use super::instance::Instance;
use super::kernel::{Kernel, KernelKey, as_given};
use super::kernel_cache::KernelCache;
use super::logical_device::LogicalDevice;
use super::reflect::{has_subgroups, reflect};
use crate::error::{Error, Result};

/// A Vulkan device, opened for compute, and its kernels. Clones share both.
///
/// ```no_run
/// use milkglass::Device;
///
/// if let Some(device) = Device::best()? {
///     println!("{}, {}", device.name(), device.driver());
/// }
/// let software = Device::named("llvmpipe")?;
/// # Ok::<(), milkglass::Error>(())
/// ```
#[derive(Clone)]
pub struct Device {
    logical: LogicalDevice,
    kernels: Rc<KernelCache>,
}

impl Device {
    /// Opens an adapter, or says why it can't be used; fails if it does not execute a dispatch.
    pub fn open(instance: &Instance, adapter: &Adapter) -> Result<Self> {
        Self::open_as(instance, adapter, &Choices::default())
    }

    /// Opens an adapter and uses it as `choices` say; fails where the adapter lacks what they need.
    pub fn open_as(instance: &Instance, adapter: &Adapter, choices: &Choices) -> Result<Self> {
        let logical = LogicalDevice::open(instance, adapter, choices, &Extras::default())?;
        let device = Self { logical, kernels: Rc::default() };
        verify_execution(&device)?;
        Ok(device)
    }

    /// Opens an adapter for what its compiler says of pipelines: none is to be used, and nothing of the device is
    /// destroyed, since drivers of null hardware crash there. With `keeps_code` pipelines keep their code, too.
    pub fn compiler(instance: &Instance, adapter: &Adapter, keeps_code: bool) -> Result<Self> {
        let extras = Extras { statistics: true, code: keeps_code, ..Extras::default() };
        if !adapter.offers.statistics {
            let what = "it lacks VK_KHR_pipeline_executable_properties, by which compilers report";
            return Err(Error::device(format!("asking the compiler of {}", adapter.name), what));
        }
        let logical = LogicalDevice::open(instance, adapter, &Choices::default(), &extras)?;
        logical.give_up();
        Ok(Self { logical, kernels: Rc::default() })
    }

    /// Opens the same adapter once more, with the same features and replaced kernels, and uses it as `choices` say.
    pub fn opened_as(&self, choices: &Choices) -> Result<Self> {
        Ok(Self { logical: self.logical.again(choices, self.extras())?, kernels: Rc::new(self.kernels.forgetting()) })
    }

    /// The same device, with kernels made anew when they are needed.
    #[must_use]
    pub fn forgetting_kernels(&self) -> Self {
        Self { logical: self.logical.clone(), kernels: Rc::new(self.kernels.forgetting()) }
    }

    /// The best usable device: discrete, then integrated, then virtual, then software, each in the loader's order.
    /// None where the machine has no Vulkan device that milkglass can use.
    pub fn best() -> Result<Option<Self>> {
        let Ok(instance) = Instance::open(false) else {
            return Ok(None);
        };
        let adapters = instance.adapters()?;
        Adapter::best(&adapters).map(|adapter| Self::open(&instance, adapter)).transpose()
    }

    /// The device of this number (as `milkglass devices` counts), or with this text in its name.
    pub fn named(wish: &str) -> Result<Self> {
        let instance = Instance::open(false)?;
        let adapters = instance.adapters()?;
        Self::open(&instance, Adapter::find(&adapters, wish)?)
    }

    /// The same device, with this SPIR-V in place of a kernel of the build, and able to run it: see `able`.
    /// Nothing else is checked: see [`super::replacements`].
    pub fn replacing(&self, kernel: &str, words: Vec<u32>) -> Result<Self> {
        let able = self.able(kernel, &words)?;
        Ok(Self { kernels: Rc::new(able.kernels.replacing(kernel, words)), ..able })
    }

    /// The same device, opened once more if the capabilities of this SPIR-V need features that it was not opened with.
    /// Fails if the device lacks one, or does not grant the full subgroups that this SPIR-V takes for granted.
    pub(crate) fn able(&self, kernel: &str, words: &[u32]) -> Result<Self> {
        let doing = || format!("preparing kernel {kernel}");
        self.grants_subgroups_to(kernel, words)?;
        let needed = needed(words).map_err(|name| Error::device(doing(), format!("it has the capability {name}")))?;
        let mut extras = self.extras().clone();
        let mut offered = Features::query(&self.instance().0.raw, self.adapter().physical);
        if let Some((capability, feature)) = offered.lacking(&needed) {
            let what =
                format!("its capability {capability:?} needs the feature {feature}, which {} lacks", self.name());
            return Err(Error::device(doing(), what));
        }
        extras.features.extend(needed.iter().map(|(_, feature)| feature));
        if extras == *self.extras() {
            return Ok(self.clone());
        }
        Ok(Self { logical: self.logical.again(self.choices(), &extras)?, kernels: Rc::new(self.kernels.forgetting()) })
    }

    /// Fails if this SPIR-V shares values in subgroups, and they would not be full.
    fn grants_subgroups_to(&self, kernel: &str, words: &[u32]) -> Result<()> {
        if !has_subgroups(words) || self.grants_full_subgroups(reflect(kernel, words)?.across) {
            return Ok(());
        }
        let what = format!(
            "it has subgroup operations, and {} does not grant it full subgroups; `#define WITHOUT_SUBGROUPS` before \
             #include \"shuffle.glsl\" does without",
            self.name()
        );
        Err(Error::device(format!("preparing kernel {kernel}"), what))
    }

    /// The same device, with kernels that count what they do, and are slower for it: see [`super::Kernels::tallies`].
    #[must_use]
    pub fn counting(&self) -> Self {
        Self { logical: self.logical.clone(), kernels: Rc::new(self.kernels.counting()) }
    }

    /// The same adapter opened once more, with the same kernels replaced and none made so far. Pipelines keep what the
    /// driver's compiler says of them, where it offers that: see [`super::Kernels::facts`].
    pub fn with_statistics(&self) -> Result<Self> {
        let extras = Extras { statistics: self.offers(STATISTICS)?, ..self.extras().clone() };
        Ok(Self { logical: self.logical.again(self.choices(), &extras)?, kernels: Rc::new(self.kernels.forgetting()) })
    }

    /// The same device with the kernels of the build only, none of which are made so far.
    #[must_use]
    pub fn built_in(&self) -> Self {
        Self { logical: self.logical.clone(), kernels: Rc::default() }
    }

    /// The kernels that do not come from the build.
    pub fn replaced(&self) -> impl Iterator<Item = &str> {
        self.kernels.replaced()
    }

    /// The extensions that it was opened with, and others that its driver offers.
    #[cfg(feature = "measure")]
    pub fn extensions(&self) -> [Vec<String>; 2] {
        self.logical.extensions()
    }

    /// The features that it was opened with, and others that kernels can have it opened with, where it offers them.
    #[cfg(feature = "measure")]
    pub fn features(&self) -> [Vec<String>; 2] {
        let mut offered = Features::query(&self.instance().0.raw, self.adapter().physical);
        let full = self.adapter().offers.full_subgroups.then_some("computeFullSubgroups");
        let used = self.extras().features.iter().copied().chain(["scalarBlockLayout"]).chain(full);
        let others = offered.all().filter(|name| !self.extras().features.contains(name));
        [used.map(String::from).collect(), others.map(String::from).collect()]
    }

    /// The SPIR-V of a kernel as the driver is given it.
    pub fn words(&self, kernel: &str) -> Result<Vec<u32>> {
        Ok(as_given(&self.logical, self.kernels.words(&self.logical, kernel)?))
    }

    // Methods that callers name by a path, such as `Device::name`: paths do not look through `Deref`.

    /// The adapter's name.
    pub fn name(&self) -> &str {
        self.logical.name()
    }

    /// The driver's name and version.
    pub fn driver(&self) -> &str {
        self.logical.driver()
    }

    /// The adapter's limits.
    pub fn limits(&self) -> &Limits {
        self.logical.limits()
    }

    /// Takes the validation messages that have come since the last call.
    pub fn take_messages(&self) -> Vec<String> {
        self.logical.take_messages()
    }

    /// The kernel of this key, made if need be.
    pub(super) fn kernel(&self, key: &KernelKey) -> Result<Rc<Kernel>> {
        self.kernels.get(&self.logical, key)
    }
}

impl Deref for Device {
    type Target = LogicalDevice;

    fn deref(&self) -> &LogicalDevice {
        &self.logical
    }
}
