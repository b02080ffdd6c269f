//! How walks are watched: how long they may take, how far they have got, and who is told.

use std::time::{Duration, Instant};

use crate::error::{Input, Result};

/// Seconds from which a walk says how long it takes.
const LONG: f64 = 10.0;
/// How long photons start before their number tells how long the walk takes.
const SURE: Duration = Duration::from_secs(1);

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
    /// Seed of the photons' random numbers.
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
    /// Since when photons of the number now asked for start, and how many of a channel had started before.
    since: Option<(Instant, f64)>,
    told: bool,
}

impl Course {
    /// A walk that begins now; an error if its time is beyond the limit.
    pub fn new(object: usize, end: End, control: WalkControl) -> Result<Self> {
        if let (End::Within(time), Some(limit)) = (end, control.limit.filter(|limit| end_of(end) > Some(*limit))) {
            return Err(beyond("a walk of a given time", &format!("{} s", time.as_secs_f64()), limit));
        }
        Ok(Self { object, begin: Instant::now(), end, control, known: None, since: None, told: false })
    }

    /// Photons of each channel that it takes in all; unknown before the first ones have told their noise.
    pub fn needed(&self) -> Option<f64> {
        match self.end {
            End::Photons(photons) => Some(photons.into()),
            End::Within(_) => Some(f64::INFINITY),
            End::Noise(goal) => self.known.map(|(photons, noise)| photons * (noise / goal).powi(2)),
        }
    }

    /// Takes note of the noise that `photons` of each channel left.
    pub fn learn(&mut self, photons: u32, noise: f64) {
        self.known = Some((photons.into(), noise));
    }

    /// Takes note that more photons of each channel are about to start, after `done` of them.
    pub fn go_on(&mut self, done: u32) {
        self.since = Some((Instant::now(), done.into()));
    }

    /// Says how long the walk takes, or refuses it, once that can be told from the photons that have started since
    /// [`Self::go_on`]: the first ones leave most of a device idle, and their time tells nothing.
    pub fn foretell(&mut self, started: f64) -> Result<()> {
        let Some((since, before)) = self.since.filter(|(since, _)| since.elapsed() >= SURE) else { return Ok(()) };
        let rate = (started - before) / since.elapsed().as_secs_f64();
        match self.needed().filter(|needed| needed.is_finite() && rate > 0.0) {
            Some(needed) => self.judge(needed, self.begin.elapsed().as_secs_f64() + (needed - started).max(0.0) / rate),
            None => Ok(()),
        }
    }

    /// Says that the walk takes so many photons a channel and so many seconds in all, if that is long; an error if it
    /// is beyond the limit.
    fn judge(&mut self, needed: f64, seconds: f64) -> Result<()> {
        self.since = None;
        let about = format!("about {needed:.1e} photons a channel, {}", seconds_of(seconds));
        if let Some(limit) = self.control.limit.filter(|limit| seconds > limit.as_secs_f64()) {
            return Err(beyond(&format!("{} takes {about}", self.named()), &seconds_of(seconds), limit));
        }
        if let Some(tell) = self.control.tell.filter(|_| !self.told && seconds > LONG) {
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
                let what = format!("{} takes too long: its first photons alone do", self.named());
                Err(beyond(&what, &format!("more than {} s", limit.as_secs_f64()), limit))
            }
        }
    }

    /// The walk in words, by what ends it.
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
    let least = format!("at most {} s: fewer photons, or a larger --limit-time", limit.as_secs_f64());
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
    fn the_time_of_a_walk_is_told_from_its_own_photons() {
        let limited = |limit: u64| {
            let control = WalkControl { limit: Some(Duration::from_secs(limit)), ..WalkControl::default() };
            let mut walk = Course::new(0, End::Photons(9000), control).unwrap();
            let ago = |seconds: u64| Instant::now().checked_sub(Duration::from_secs(seconds)).unwrap();
            // A pilot of 1000 photons took 8 s, most of them to compile; the next 2000 took 2 s, so 8 s are to come.
            walk.begin = ago(10);
            walk.since = Some((ago(2), 1000.0));
            (walk.foretell(3000.0), walk.since.is_none())
        };
        let (told, judged) = limited(17);
        assert!(told.is_ok() && judged);
        let error = limited(15).0.unwrap_err();
        assert!(error.to_string().contains("about 9.0e3 photons a channel, 16 s"), "{error}");
        // Too early to tell.
        let mut walk = course(End::Photons(9000));
        walk.go_on(1000);
        assert!(walk.foretell(2000.0).is_ok() && walk.since.is_some());
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
