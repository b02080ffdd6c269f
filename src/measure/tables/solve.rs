//! One model solved by the scheme as published: links, times, and error against brute force in `f64`.

use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::modes::{What, moved};
use crate::measure::norms::{Norms, norms, worst};
use crate::measure::reference::{radiosity, receivers};
use crate::measure::sample::Sample;
use crate::measure::statistics::median;
use crate::pipeline::plan::{Change, Goal, Mode, Options};
use crate::scene::Scene;
use crate::session::run::Session;
use crate::transport::links::form_factor;

/// Maximum number of timed frames, and the total milliseconds after which timing stops.
const FRAMES: usize = 5;
const LONG: f64 = 2000.0;

/// What is kept between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// Nothing: the paper's on-the-fly mode.
    Nothing,
    /// Links and form factors: the paper's render mode.
    Links,
    /// Links and form factors while the shape changes: the paper's incremental mode. In each frame a bump on 1 % of the
    /// triangles moves.
    Altered,
}

/// Radiosity by brute force in `f64` at a sample of faces.
pub struct Truth {
    sample: Sample,
    radiosity: Vec<[f64; 3]>,
}

/// A model after its first frame, which is the warm-up.
pub struct Solved {
    session: Session,
    change: Change,
    /// The scene whose shape changes, and the number of frames in which it has changed.
    altered: Option<(Scene, usize)>,
}

impl Solved {
    /// Opens a scene and solves it once.
    pub fn new(scene: &Scene, device: Option<&Device>, kept: Kept) -> Result<Self> {
        let (mode, change) = match kept {
            Kept::Nothing => (Mode::OnTheFly, Change::EVERYTHING),
            Kept::Links => (Mode::Render, Change::LIGHT),
            Kept::Altered => (Mode::Incremental, Change::default()),
        };
        let altered = (kept == Kept::Altered).then(|| (scene.clone(), 0));
        let scene = if altered.is_some() { &moved(scene, What::Bump, 0) } else { scene };
        let options = Options { mode, goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(scene, device, options)?;
        session.frame(Change::EVERYTHING)?;
        session.fetch(&[BufferId::spans, BufferId::irradiance, BufferId::radiosity, BufferId::clusters])?;
        Ok(Self { session, change, altered })
    }

    /// Opens a scene and solves it once; `None` if its links are too many to keep.
    pub fn if_it_fits(scene: &Scene, device: Option<&Device>, kept: Kept) -> Result<Option<Self>> {
        match Self::new(scene, device, kept) {
            Ok(solved) if solved.session.not_kept().is_some() => Ok(None),
            Err(Error::TooMuchToKeep { .. }) => Ok(None),
            done => done.map(Some),
        }
    }

    /// Number of triangles.
    #[must_use]
    pub fn faces(&self) -> usize {
        self.session.state().data.triangles.len()
    }

    /// Number of links.
    #[must_use]
    pub fn links(&self) -> u64 {
        self.session.state().data.spans.iter().map(|span| u64::from(span.links)).sum()
    }

    /// Number of links to triangles too near for a few samples: by the edge form, or by uniform samples.
    #[must_use]
    pub fn near_links(&self) -> u64 {
        self.session.state().data.spans.iter().map(|span| u64::from(span.edges)).sum()
    }

    /// Links per triangle.
    #[must_use]
    pub fn links_per_face(&self) -> f64 {
        self.links() as f64 / self.faces().max(1) as f64
    }

    /// Median time of a frame in this mode, milliseconds.
    pub fn time(&mut self) -> Result<f64> {
        let mut times = Vec::new();
        while times.len() < FRAMES && times.iter().sum::<f64>() < LONG {
            times.push(self.frame()?[0]);
        }
        Ok(median(times))
    }

    /// Median times of two models, milliseconds: of the whole frame and of its stage `form_factor`. Frames alternate,
    /// so that other load on the machine slows both.
    pub fn time_beside(&mut self, other: &mut Self) -> Result<[[f64; 2]; 2]> {
        let mut times: [[Vec<f64>; 2]; 2] = Default::default();
        while times[0][0].len() < FRAMES && times.iter().flat_map(|model| &model[0]).sum::<f64>() < LONG {
            for (solved, times) in [&mut *self, &mut *other].into_iter().zip(&mut times) {
                let [whole, part] = solved.frame()?;
                times[0].push(whole);
                times[1].push(part);
            }
        }
        Ok(times.map(|model| model.map(median)))
    }

    /// Milliseconds of one frame and of its stage `form_factor`.
    fn frame(&mut self) -> Result<[f64; 2]> {
        if let Some((scene, step)) = &mut self.altered {
            *step += 1;
            self.session.show(&moved(scene, What::Bump, *step))?;
        }
        let parts = self.session.frame(self.change)?;
        let factors = parts.iter().filter(|part| part.name == form_factor::STAGE.name);
        let [all, factors] =
            [parts.iter().map(|part| part.milliseconds).sum(), factors.map(|part| part.milliseconds).sum()];
        Ok([all, factors])
    }

    /// Reference radiosity at `samples` seeded faces.
    #[must_use]
    pub fn truth(&self, samples: usize) -> Truth {
        let sample = receivers(self.session.state(), samples, 1);
        let radiosity = radiosity(self.session.state(), &sample.faces);
        Truth { sample, radiosity }
    }

    /// Error norms against the reference, worst channel.
    #[must_use]
    pub fn error(&self, truth: &Truth) -> Norms {
        let data = &self.session.state().data;
        let values: Vec<[f64; 3]> =
            truth.sample.faces.iter().map(|&face| data.radiosity[face].map(f64::from)).collect();
        worst(&norms(&truth.sample, &values, &truth.radiosity))
    }

    /// Difference to another solution of the same scene, relative to that one's rms over the faces: per face, and
    /// averaged at the vertices as in a picture, where only low-frequency noise remains. Largest over the channels.
    #[must_use]
    pub fn noise(&self, other: &Self) -> [f64; 2] {
        let (data, theirs) = (&self.session.state().data, &other.session.state().data.radiosity);
        let count = data.radiosity.len().max(1) as f64;
        let difference = |face: usize, c: usize| f64::from(data.radiosity[face][c]) - f64::from(theirs[face][c]);
        let mut largest = [0.0f64; 2];
        for c in 0..3 {
            let rms = (theirs.iter().map(|b| f64::from(b[c]).powi(2)).sum::<f64>() / count).sqrt();
            let faces = (0..theirs.len()).map(|face| difference(face, c).powi(2)).sum::<f64>() / count;
            let vertices = data.corner_starts.windows(2).map(|range| {
                let around = &data.corners[range[0] as usize..range[1] as usize];
                around.iter().map(|&face| difference(face as usize, c)).sum::<f64>() / around.len().max(1) as f64
            });
            let vertices = vertices.map(|x| x * x).sum::<f64>() / data.positions.len().max(1) as f64;
            for (largest, square) in largest.iter_mut().zip([faces, vertices]) {
                *largest = largest.max(if rms > 0.0 { square.sqrt() / rms } else { 0.0 });
            }
        }
        largest
    }

    /// Mean number of uniform samples per triangle by Jensen and Buhler's criterion.
    #[must_use]
    pub fn samples(&self) -> f64 {
        use crate::dipole::form_factor::uniform::{count, density};
        let data = &self.session.state().data;
        let each =
            data.leaves.iter().map(|&leaf| count(data.clusters[leaf as usize].area, density(&data.object_params[0])));
        each.map(f64::from).sum::<f64>() / data.leaves.len().max(1) as f64
    }
}
