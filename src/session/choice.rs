//! Which objects of a scene diffusion serves, and why not the others: all of them or none, or those where it holds.

use super::run::Session;
use crate::error::{Input, Result};
use crate::pipeline::plan::{Options, Plan, ShadingMethod};
use crate::prepare::diffusion_validity::{Inside, Validity, enclosed};
use crate::scene::{Object, Receivers, Scene, Scheme};

/// The choice of a session.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choice {
    /// The transport that was asked for.
    transport: ShadingMethod,
    /// The properties of each object's shape at rest on which the choice depends; none for an opaque object. Empty
    /// where nothing is chosen.
    shapes: Vec<Option<Inside>>,
    /// Whether diffusion holds in each object.
    validity: Vec<Validity>,
}

impl Choice {
    /// Chooses for each object; an error where diffusion is asked for and has no meaning. Shapes are those of the
    /// choice `before`, if its meshes were the same.
    pub fn of(scene: &Scene, transport: ShadingMethod, before: Option<(&Self, &Scene)>) -> Result<Self> {
        if !matches!(transport, ShadingMethod::Diffusion | ShadingMethod::Auto) {
            return Ok(Self { transport, ..Self::default() });
        }
        if scene.transport.receivers == Receivers::Pixels {
            let fault = Input::new("diffusion is solved at triangles").key("transport.receivers").found("pixels");
            return Err(fault.expected("faces or auto, or --transport hierarchy").into());
        }
        if transport == ShadingMethod::Auto && scene.transport.scheme == Scheme::Links {
            let what = "where diffusion does not hold, auto takes scheme blocks";
            let fault = Input::new(what).key("transport.scheme").found(format!("links: {}", scene.transport.because));
            return Err(fault.expected("keys of scheme blocks, or --transport hierarchy").into());
        }
        if transport == ShadingMethod::Diffusion {
            closed(scene)?;
        }
        let shape = |(number, object): (usize, &Object)| {
            let known = before.filter(|(_, old)| old.objects.get(number).is_some_and(|old| old.mesh == object.mesh));
            let known = known.and_then(|(choice, _)| choice.shapes.get(number).cloned().flatten());
            object.material.opaque.is_none().then(|| known.unwrap_or_else(|| Inside::of(&object.mesh)))
        };
        let shapes: Vec<Option<Inside>> = scene.objects.iter().enumerate().map(shape).collect();
        let validity = validity(&shapes, scene);
        Ok(Self { transport, shapes, validity })
    }

    /// For each object whether diffusion serves it.
    pub fn solves(&self, scene: &Scene) -> Vec<bool> {
        let serves = |(number, object): (usize, &Object)| {
            let translucent = object.material.opaque.is_none();
            match self.transport {
                ShadingMethod::Diffusion => translucent,
                ShadingMethod::Auto => translucent && self.validity[number].unfit.is_none(),
                _ => false,
            }
        };
        scene.objects.iter().enumerate().map(serves).collect()
    }

    /// Whether other materials of the same objects lead to the same choice.
    pub fn stays(&self, scene: &Scene) -> bool {
        let fit = |all: &[Validity]| all.iter().map(|known| known.unfit.is_none()).collect::<Vec<_>>();
        self.transport != ShadingMethod::Auto || fit(&validity(&self.shapes, scene)) == fit(&self.validity)
    }

    /// Takes over other materials of the same objects.
    pub fn adopt(&mut self, scene: &Scene) {
        if !self.validity.is_empty() {
            self.validity = validity(&self.shapes, scene);
        }
    }

    /// A plan that says which objects diffusion does not serve.
    pub fn told(&self, plan: Plan) -> Plan {
        if self.transport != ShadingMethod::Auto {
            return plan;
        }
        let unfit =
            self.validity.iter().enumerate().filter_map(|(number, known)| Some((number, known.unfit.as_ref()?)));
        unfit.fold(plan, |plan, (number, why)| {
            plan.without(("diffusion", format!("of object {number}, the dipole serves instead: {why}")))
        })
    }
}

/// Whether diffusion holds in each object.
fn validity(shapes: &[Option<Inside>], scene: &Scene) -> Vec<Validity> {
    let known = |(shape, object): (&Option<Inside>, &Object)| {
        shape.as_ref().filter(|_| object.material.opaque.is_none()).map(|shape| shape.validity(&object.material))
    };
    shapes.iter().zip(&scene.objects).map(|pair| known(pair).unwrap_or_default()).collect()
}

/// An error where diffusion inside an object has no meaning.
pub(crate) fn closed(scene: &Scene) -> Result<()> {
    let inside = "diffusion is solved inside a closed object";
    enclosed(&scene.objects, "diffusion", [inside, "light enters from outside only where diffusion is solved"])
}

impl Session {
    /// The plan of the state as it is.
    pub(super) fn plan_of(&self, options: Options) -> Plan {
        self.choice.told(Plan::new(&self.prepared.state, options).without(self.fixed.receivers.clone()))
    }

    /// A line for each object in which diffusion does not hold, or errs by more than usual.
    #[must_use]
    pub fn diffusion_doubts(&self) -> Vec<String> {
        let auto = self.choice.transport == ShadingMethod::Auto;
        let line = |(number, known): (usize, &Validity)| match (&known.unfit, &known.doubt) {
            (Some(why), _) if auto => Some(format!("object {number}: the dipole, not diffusion: {why}")),
            (Some(why), _) => Some(format!("object {number}: diffusion promises nothing: {why}")),
            (None, Some(why)) => Some(format!("object {number}: diffusion may be off by 10 to 40 %: {why}")),
            (None, None) => None,
        };
        self.choice.validity.iter().enumerate().filter_map(line).collect()
    }
}
