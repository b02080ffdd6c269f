//! How walks are watched: how long they may take, how far they have got, and who is told.

use std::time::{Duration, Instant};

use crate::error::{Input, Result};

/// Seconds from which a walk says how long it takes.
const LONG: f64 = 10.0;

/// How a session's walks are watched.
#[derive(Clone, Copy, Default)]
pub struct WalkControl {
    /// The longest that a walk may take: one that will take longer is refused once that is known.
    pub limit: Option<Duration>,
    /// How long each object's walk goes on, whatever its noise: in the place of `transport.walk_error` and `walks`.
    pub within: Option<Duration>,
    /// Asked between rounds whether to end with what there is.
    pub stop: Option<fn() -> bool>,
    /// Told how long a walk takes.
    pub tell: Option<fn(&str)>,
    /// Told between rounds how far a walk has got, and `None` at its end.
    pub show: Option<fn(Option<&WalkProgress>)>,
    /// Other numbers, other photons.
    pub seed: u32,
}

/// How far a walk has got.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkProgress {
    /// The object.
    pub object: usize,
    /// Share of the photons, or of the time, that it is to take, 0 to 1.
    pub done: f64,
    /// Seconds left, once they can be estimated.
    pub left: Option<f64>,
    /// Relative error of the radiosity's means over patches, L2, once it is known.
    pub noise: Option<f64>,
    /// The error that ends it, if one does.
    pub goal: Option<f64>,
}

/// What ends a walk.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    /// An estimated error.
    Noise(f64),
    /// A number of photons of each channel.
    Photons(u32),
    /// A time.
    Within(Duration),
}

/// One object's walk, under way.
pub(super) struct Course {
    pub object: usize,
    pub begin: Instant,
    pub end: End,
    pub control: WalkControl,
    /// Photons of each channel, and the noise that they left.
    known: Option<(f64, f64)>,
    /// Rounds of slots with a photon under way; and of those in rounds full of them, how many, and their seconds.
    work: f64,
    busy: [f64; 2],
    told: bool,
}

impl Course {
    /// A walk that begins now; an error if its time is beyond the limit.
    pub fn new(object: usize, end: End, control: WalkControl) -> Result<Self> {
        if let (End::Within(time), Some(limit)) = (end, control.limit.filter(|limit| end_of(end) > Some(*limit))) {
            return Err(beyond("a walk of a given time", &format!("{} s", time.as_secs_f64()), limit));
        }
        Ok(Self { object, begin: Instant::now(), end, control, known: None, work: 0.0, busy: [0.0; 2], told: false })
    }

    /// Photons of each channel that it takes in all; unknown before the first ones have told their noise.
    pub fn needed(&self) -> Option<f64> {
        match self.end {
            End::Photons(photons) => Some(photons.into()),
            End::Within(_) => Some(f64::INFINITY),
            End::Noise(goal) => self.known.map(|(photons, noise)| photons * (noise / goal).powi(2)),
        }
    }

    /// The noise of so many photons is known.
    pub fn learn(&mut self, photons: u32, noise: f64) {
        self.known = Some((photons.into(), noise));
    }

    /// A round took so long, with so many photons under way before and after it, of as many as there can be.
    pub fn round(&mut self, seconds: f64, before: f64, after: f64, slots: f64) {
        let work = 0.5 * (before + after);
        self.work += work;
        // With fewer, neighbours wait for each other; a walk of many photons has few only at its end.
        if self.busy[0] == 0.0 || after > 0.9 * slots {
            self.busy = [self.busy[0] + work, self.busy[1] + seconds];
        }
    }

    /// Seconds that a walk of so many photons takes in all, of which `done` have been walked.
    fn expected(&self, done: f64, needed: f64, elapsed: f64) -> f64 {
        let [work, seconds] = self.busy;
        let each = if work > 0.0 { self.work / done * seconds / work } else { elapsed / done };
        elapsed + (needed - done).max(0.0) * each
    }

    /// Says how long a walk of so many photons takes of which `done` have been walked, or refuses it.
    pub fn foretell(&mut self, done: u32, needed: f64) -> Result<()> {
        let expected = self.expected(done.into(), needed, self.begin.elapsed().as_secs_f64());
        let about = format!("about {needed:.1e} photons a channel, {}", seconds_of(expected));
        if let Some(limit) = self.control.limit.filter(|limit| expected > limit.as_secs_f64()) {
            return Err(beyond(&format!("{} takes {about}", self.named()), &seconds_of(expected), limit));
        }
        if let Some(tell) = self.control.tell.filter(|_| !self.told && expected > LONG) {
            tell(&format!("long: object {} takes {about}; Ctrl-C ends with what there is", self.object));
            self.told = true;
        }
        Ok(())
    }

    /// An error if the first photons alone, which tell how long it takes, take longer than is allowed.
    pub fn bounded(&self) -> Result<()> {
        let late = |limit: &Duration| self.known.is_none() && self.begin.elapsed() > *limit;
        match self.control.limit.filter(late) {
            None => Ok(()),
            Some(limit) => {
                let what = format!("{} takes longer than its first photons, which do already", self.named());
                Err(beyond(&what, &format!("more than {} s", limit.as_secs_f64()), limit))
            }
        }
    }

    /// The walk, by what ends it.
    fn named(&self) -> String {
        match self.end {
            End::Noise(goal) => format!("a walk to transport.walk_error = {goal}"),
            End::Photons(photons) => format!("a walk of transport.walks = {photons}"),
            End::Within(_) => "a walk of a given time".into(),
        }
    }

    /// Whether to end with what there is.
    pub fn over(&self) -> bool {
        self.control.stop.is_some_and(|stop| stop())
            || end_of(self.end).is_some_and(|time| self.begin.elapsed() >= time)
    }

    /// Shows how far it has got when so many photons of a channel have started.
    pub fn show(&self, started: f64) {
        let Some(show) = self.control.show else { return };
        show(Some(&self.progress(started, self.begin.elapsed().as_secs_f64())));
    }

    fn progress(&self, started: f64, seconds: f64) -> WalkProgress {
        let (done, left) = match (self.end, self.needed()) {
            (End::Within(time), _) => {
                let whole = time.as_secs_f64();
                ((seconds / whole).min(1.0), Some((whole - seconds).max(0.0)))
            }
            (_, Some(needed)) if needed > 0.0 && started > 0.0 => {
                let done = (started / needed).min(1.0);
                (done, Some(seconds * (1.0 - done) / done))
            }
            _ => (0.0, None),
        };
        let noise = self.known.map(|(photons, noise)| noise * (photons / started.max(photons)).sqrt());
        let goal = match self.end {
            End::Noise(goal) => Some(goal),
            _ => None,
        };
        WalkProgress { object: self.object, done, left, noise, goal }
    }
}

impl Drop for Course {
    fn drop(&mut self) {
        if let Some(show) = self.control.show {
            show(None);
        }
    }
}

fn end_of(end: End) -> Option<Duration> {
    match end {
        End::Within(time) => Some(time),
        _ => None,
    }
}

/// Seconds, in two digits or whole ones.
fn seconds_of(x: f64) -> String {
    if x < 10.0 { format!("{x:.1} s") } else { format!("{x:.0} s") }
}

fn beyond(what: &str, found: &str, limit: Duration) -> crate::error::Error {
    let least = format!("at most {} s: less to walk, or --limit-time", limit.as_secs_f64());
    Input::new(what).key("--limit-time").found(found).expected(least).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(end: End) -> Course {
        Course::new(3, end, WalkControl::default()).unwrap()
    }

    #[test]
    fn time_left_follows_the_photons() {
        let mut walk = course(End::Noise(0.02));
        let none = WalkProgress { object: 3, done: 0.0, left: None, noise: None, goal: Some(0.02) };
        assert_eq!(walk.progress(100.0, 1.0), none);
        // Half the noise needs four times the photons.
        walk.learn(1000, 0.04);
        let found = walk.progress(2000.0, 5.0);
        assert_eq!((found.done, found.left), (0.5, Some(5.0)));
        assert!((found.noise.unwrap() - 0.04 / 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(walk.progress(9000.0, 5.0).left, Some(0.0));
        let walk = course(End::Photons(400));
        assert_eq!(
            walk.progress(100.0, 2.0),
            WalkProgress { object: 3, done: 0.25, left: Some(6.0), noise: None, goal: None }
        );
        let walk = course(End::Within(Duration::from_secs(8)));
        assert_eq!(walk.progress(100.0, 2.0).left, Some(6.0));
    }

    #[test]
    fn the_first_photons_foretell_the_time_without_their_end() {
        // 100 slots: full for a second, then ever fewer in rounds that take as long by waiting.
        let mut walk = course(End::Photons(1100));
        walk.round(1.0, 100.0, 100.0, 100.0);
        walk.round(1.0, 100.0, 60.0, 100.0);
        walk.round(1.0, 60.0, 20.0, 100.0);
        walk.round(1.0, 20.0, 0.0, 100.0);
        // 230 rounds of a slot for a hundred photons, 100 in a second.
        assert!((walk.expected(100.0, 1100.0, 4.0) - (4.0 + 10.0 * 230.0 / 100.0)).abs() < 1e-9);
        assert_eq!(course(End::Photons(9)).expected(2.0, 4.0, 3.0), 6.0);
    }

    #[test]
    fn a_time_beyond_the_limit_is_refused() {
        let control = WalkControl { limit: Some(Duration::from_secs(5)), ..WalkControl::default() };
        let refused = |seconds| Course::new(0, End::Within(Duration::from_secs(seconds)), control).err();
        assert!(refused(5).is_none());
        let error = refused(6).unwrap();
        assert!(error.exit_code() == 2 && error.to_string().contains("found 6 s; expected at most 5 s"), "{error}");
    }
}
