//! The processor time that other programs take while something is timed, as Linux counts it.

use std::fs::read_to_string;

/// Counts of processor time in ticks: since the machine started, or over some time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Load {
    /// Ticks of the processes that are timed.
    own: f64,
    /// Ticks of all processes.
    busy: f64,
    /// Ticks of all processors, whether at work or not.
    all: f64,
    /// Number of processors.
    cores: f64,
}

impl Load {
    /// The counts now, with these processes as one's own; `None` where the system does not tell.
    pub(super) fn now(processes: &[u32]) -> Option<Self> {
        let mut known: Vec<u32> = processes.iter().copied().chain([std::process::id()]).collect();
        known.sort_unstable();
        known.dedup();
        let own = known.iter().map(|process| ticks(&read_to_string(format!("/proc/{process}/stat")).ok()?));
        Self::parsed(&read_to_string("/proc/stat").ok()?, own.sum::<Option<f64>>()?)
    }

    /// The counts of `/proc/stat`.
    fn parsed(stat: &str, own: f64) -> Option<Self> {
        let lines = || stat.lines().filter(|line| line.starts_with("cpu"));
        let counts: Vec<f64> = lines().next()?.split_whitespace().skip(1).map_while(|word| word.parse().ok()).collect();
        // User, nice, system, idle, waiting, interrupts, soft interrupts, stolen; guests are in user.
        let [user, nice, system, idle, waiting, hard, soft, stolen] = *counts.first_chunk()?;
        let busy = user + nice + system + hard + soft + stolen;
        Some(Self { own, busy, all: busy + idle + waiting, cores: (lines().count() - 1).max(1) as f64 })
    }

    /// What was counted since then.
    pub(super) fn since(&self, then: &Self) -> Self {
        let Self { own, busy, all, .. } = then;
        Self { own: self.own - own, busy: self.busy - busy, all: self.all - all, ..*self }
    }

    /// Both times together.
    pub(super) fn plus(&self, other: &Self) -> Self {
        let Self { own, busy, all, cores } = other;
        Self { own: self.own + own, busy: self.busy + busy, all: self.all + all, cores: *cores }
    }

    /// How many processors other programs kept busy on average over this time.
    pub(super) fn others(&self) -> f64 {
        ((self.busy - self.own) * self.cores / self.all.max(1.0)).max(0.0)
    }
}

/// The processor time of a process, all threads together, from its `/proc/PID/stat`. Its name may contain anything.
fn ticks(stat: &str) -> Option<f64> {
    let words: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    Some(words.get(11)?.parse::<f64>().ok()? + words.get(12)?.parse::<f64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_are_what_is_busy_and_not_ours() {
        let stat =
            |user: u32, idle: u32| format!("cpu  {user} 5 10 {idle} 3 0 1 0 0 0\ncpu0 1 0 0 0\ncpu1 1 0 0 0\nintr 7\n");
        let then = Load::parsed(&stat(100, 1000), 50.0).unwrap();
        // 200 ticks of both processors: 150 busy, 30 of them ours.
        let now = Load::parsed(&stat(250, 1050), 80.0).unwrap();
        let passed = now.since(&then);
        assert!((passed.others() - 1.2).abs() < 1e-12, "{}", passed.others());
        assert_eq!(Load::default().plus(&passed).plus(&passed).others(), passed.others());
        assert_eq!((now.since(&now).others(), Load::parsed("cpu 1 2", 0.0), Load::parsed("", 0.0)), (0.0, None, None));
        assert_eq!(ticks("7 (a b) c) R 1 2 3 4 5 6 7 8 9 10 11 12 13"), Some(23.0));
        assert_eq!(ticks("7 (a) R 1"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_tells() {
        let then = Load::now(&[]).unwrap();
        assert!(then.all > 0.0 && then.since(&then).others() == 0.0);
        assert!(Load::now(&[u32::MAX]).is_none());
    }
}
