//! Opening a device once more, the facts of the device that this needs, and whether it compiles kernels ahead.

use std::time::Duration;

use super::LogicalDevice;
#[cfg(feature = "measure")]
use super::create::extension_names;
use crate::error::Result;
use crate::gpu::choices::Choices;
use crate::gpu::extras::Extras;
use crate::gpu::instance::Instance;

impl LogicalDevice {
    /// The same adapter opened once more; submissions may take as long.
    pub(in super::super) fn again(&self, choices: &Choices, extras: &Extras) -> Result<Self> {
        let device = Self::open(&self.0.instance, &self.0.adapter, choices, extras)?;
        device.wait_at_most(self.patience());
        device.cut_at(self.longest());
        device.compile_ahead(self.compiles_ahead());
        device.align_clocks(self.0.aligned.get());
        Ok(device)
    }

    /// Sets whether kernels are compiled ahead of the frame that first uses them, on all cores, where the driver would
    /// compile them one by one within that frame; the default is no.
    pub fn compile_ahead(&self, ahead: bool) {
        self.0.ahead.set(ahead);
    }

    /// How long a submission may take.
    pub(in super::super) fn patience(&self) -> Duration {
        self.0.patience.get()
    }

    /// How long a submission should take, where the device may have a display: none for a processor.
    pub(crate) fn shows(&self) -> Option<Duration> {
        (self.adapter().kind != "cpu").then(|| self.longest())
    }

    /// How long a submission should take.
    pub(in super::super) fn longest(&self) -> Duration {
        self.0.longest.get()
    }

    pub(in super::super) fn compiles_ahead(&self) -> bool {
        self.0.ahead.get()
    }

    /// What it was opened with on request.
    pub(in super::super) fn extras(&self) -> &Extras {
        &self.0.extras
    }

    /// The extensions that it was opened with, and others that its driver offers.
    #[cfg(feature = "measure")]
    pub(in super::super) fn extensions(&self) -> [Vec<String>; 2] {
        extension_names(&self.0.instance, &self.0.adapter, self.choices(), self.extras())
    }

    /// The version of the validation layer, if it watches.
    #[must_use]
    pub fn layer(&self) -> Option<String> {
        self.instance().layer()
    }

    pub(in super::super) fn instance(&self) -> &Instance {
        &self.0.instance
    }

    /// Submissions since the device was opened, those of copies included.
    pub fn submissions(&self) -> u64 {
        self.0.submissions.get()
    }
}
