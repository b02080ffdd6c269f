//! The device's clock beside the host's, where the driver reads its own (`VK_KHR_calibrated_timestamps` or EXT's).

use std::time::{Duration, Instant};

use ash::{ext, khr, vk};

use super::LogicalDevice;
use crate::error::Result;
use crate::gpu::adapter::Limits;
use crate::gpu::call::vk_call;

/// Of so many readings the one that took the least time is kept.
const READINGS: usize = 3;

/// A moment on both clocks.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Moment {
    /// The device's clock, in ticks of its timestamps.
    ticks: u64,
    /// The host's clock.
    host: Instant,
    /// How far apart the two readings may be.
    pub(in super::super) within: Duration,
}

impl Moment {
    /// When a timestamp was written that is older than this moment, by the host's clock.
    pub(in super::super) fn of(&self, ticks: u64, limits: &Limits) -> Option<Instant> {
        let ago = (self.ticks.wrapping_sub(ticks) & limits.timestamp_mask) as f64 * f64::from(limits.timestamp_period);
        self.host.checked_sub(Duration::from_nanos(ago as u64))
    }
}

impl LogicalDevice {
    /// Sets whether the device's clock is read after each frame that is timed, so that its times are known by the
    /// host's; the default is no. Returns whether the driver can read it.
    pub fn align_clocks(&self, aligned: bool) -> bool {
        let able = self.0.adapter.offers.clock.is_some();
        self.0.aligned.set(aligned && able);
        able
    }

    /// Both clocks now; none where that was not asked for, or the driver cannot read its own.
    pub(in super::super) fn clocks(&self, doing: &str) -> Result<Option<Moment>> {
        let Some(extension) = self.0.adapter.offers.clock.filter(|_| self.0.aligned.get()) else { return Ok(None) };
        let (instance, raw) = (&self.0.instance.0.raw, &self.0.raw);
        let wanted = [vk::CalibratedTimestampInfoKHR::default().time_domain(vk::TimeDomainKHR::DEVICE)];
        // Its functions are found before the time is taken.
        let by_khr = (extension == khr::calibrated_timestamps::NAME)
            .then(|| khr::calibrated_timestamps::Device::new(instance, raw));
        let by_ext = ext::calibrated_timestamps::Device::new(instance, raw);
        let mut best: Option<Moment> = None;
        for _ in 0..READINGS {
            let begin = Instant::now();
            // SAFETY: the device was opened with the extension, which offers the device's clock.
            let (ticks, _) = vk_call("vkGetCalibratedTimestampsKHR", doing, || unsafe {
                match &by_khr {
                    Some(by_khr) => by_khr.get_calibrated_timestamps(&wanted),
                    None => by_ext.get_calibrated_timestamps(&wanted),
                }
            })?;
            let within = begin.elapsed() / 2;
            if best.is_none_or(|best| within < best.within) {
                best = Some(Moment { ticks: ticks[0], host: begin + within, within });
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timestamp_has_its_time_by_the_hosts_clock() {
        let now = Instant::now() + Duration::from_secs(1);
        let moment = Moment { ticks: 100, host: now, within: Duration::ZERO };
        let limits = Limits { timestamp_period: 2.0, timestamp_mask: 0xff, ..Limits::default() };
        assert_eq!(now - moment.of(60, &limits).unwrap(), Duration::from_nanos(80));
        // The clock has 8 bits, and went past its end since.
        assert_eq!(now - moment.of(250, &limits).unwrap(), Duration::from_nanos(2 * (256 + 100 - 250)));
    }
}
