//! The kernels that one user of a device has asked for.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use super::count::Tally;
use super::device::Device;
use super::driver_facts::Statistic;
use super::kernel::{Kernel, KernelKey};
use crate::error::Result;

/// The kernels that one copy of a state on a device has asked for. All copies on a device share their kernels, except
/// kernels that count.
pub struct Kernels {
    device: Device,
    made: RefCell<BTreeMap<KernelKey, Rc<Kernel>>>,
}

impl Kernels {
    /// An empty collection for this device.
    pub fn new(device: &Device) -> Self {
        Self { device: device.clone(), made: RefCell::default() }
    }

    /// The kernel of this name with these specialization constants (0, 1, ...), made if need be.
    pub fn get(&self, name: &str, constants: &[u32]) -> Result<Rc<Kernel>> {
        let key = KernelKey { name: name.to_string(), constants: constants.to_vec() };
        if let Some(kernel) = self.made.borrow().get(&key) {
            return Ok(kernel.clone());
        }
        let kernel = self.device.kernel(&key)?;
        self.made.borrow_mut().insert(key, kernel.clone());
        Ok(kernel)
    }

    /// The kernels made so far.
    pub fn made(&self) -> Vec<KernelKey> {
        self.made.borrow().keys().cloned().collect()
    }

    /// How long the driver took to create each kernel's pipeline, and what its compiler says of it.
    pub fn facts(&self) -> Result<Vec<(KernelKey, Duration, Vec<Statistic>)>> {
        let made = self.made.borrow();
        made.iter().map(|(key, kernel)| Ok((key.clone(), kernel.creation, kernel.statistics()?))).collect()
    }

    /// What each dispatch has done since the last call, in their order, after its kernel's name and that of the part of
    /// the work that was timed with it; nothing where kernels do not count.
    pub fn tallies(&self) -> Result<Vec<([String; 2], Tally)>> {
        let mut all = BTreeMap::new();
        for (key, kernel) in self.made.borrow().iter() {
            let own = kernel.tallies()?.into_iter();
            all.extend(own.map(|((number, part), tally)| (number, ([key.name.clone(), part], tally))));
        }
        Ok(all.into_values().collect())
    }
}
