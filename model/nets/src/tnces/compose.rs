//! Composition: modules and composites joined at their ports (seed 003 §3.2.2, L411-421).
//!
//! Joints are Ic and Ie of the source: an output of a part to an input of a part, an input of the composite to an input
//! of a part, an output of a part to an output of the composite. A condition input carries one signal and has one
//! source. An event input may have several and is called by any of them: "the output event of both models (controller
//! and plant) is connected to the input event of this module" (L842). Every input must be driven; an output may be left
//! alone.

use super::flatten;
use super::{ComposeError, Semantics, Tnces, TncesModule};

/// A part of a composite.
#[derive(Clone, Debug)]
pub enum Element {
    /// A net with ports.
    Module(Box<TncesModule>),
    /// Parts with ports.
    Composite(Composite),
}

impl Element {
    pub fn name(&self) -> &str {
        match self {
            Element::Module(module) => &module.name,
            Element::Composite(composite) => &composite.name,
        }
    }
}

impl From<TncesModule> for Element {
    fn from(module: TncesModule) -> Element {
        Element::Module(Box::new(module))
    }
}

impl From<Composite> for Element {
    fn from(composite: Composite) -> Element {
        Element::Composite(composite)
    }
}

/// A part, numbered in the order in which it was added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ComponentId(pub usize);

/// One end of a connection: a port of a part, or one of the composite's own. A pair `(part, "port")` and a plain
/// `"port"` convert into it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Endpoint {
    /// A port of the composite.
    Own(String),
    /// A port of a part.
    Of(ComponentId, String),
}

impl From<&str> for Endpoint {
    fn from(port: &str) -> Endpoint {
        Endpoint::Own(port.to_owned())
    }
}

impl From<(ComponentId, &str)> for Endpoint {
    fn from((part, port): (ComponentId, &str)) -> Endpoint {
        Endpoint::Of(part, port.to_owned())
    }
}

/// Signal of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum PortKind {
    Condition,
    Event,
}

impl PortKind {
    pub(super) fn word(self) -> &'static str {
        match self {
            PortKind::Condition => "condition",
            PortKind::Event => "event",
        }
    }
}

/// A composite TNCES module under construction. It is checked when it is flattened.
#[derive(Clone, Debug)]
pub struct Composite {
    pub(super) name: String,
    pub(super) parts: Vec<Element>,
    pub(super) inputs: Vec<(PortKind, String)>,
    pub(super) outputs: Vec<(PortKind, String)>,
    pub(super) links: Vec<(PortKind, Endpoint, Endpoint)>,
}

impl Composite {
    /// A composite with nothing in it yet.
    pub fn new(name: impl Into<String>) -> Self {
        Composite { name: name.into(), parts: Vec::new(), inputs: Vec::new(), outputs: Vec::new(), links: Vec::new() }
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Adds a module or a composite.
    pub fn add(&mut self, part: impl Into<Element>) -> ComponentId {
        self.parts.push(part.into());
        ComponentId(self.parts.len() - 1)
    }

    /// Cm^inp: a condition input of the composite.
    pub fn condition_in(&mut self, name: impl Into<String>) -> &mut Self {
        self.inputs.push((PortKind::Condition, name.into()));
        self
    }

    /// Em^inp: an event input of the composite.
    pub fn event_in(&mut self, name: impl Into<String>) -> &mut Self {
        self.inputs.push((PortKind::Event, name.into()));
        self
    }

    /// Cm^out: a condition output of the composite.
    pub fn condition_out(&mut self, name: impl Into<String>) -> &mut Self {
        self.outputs.push((PortKind::Condition, name.into()));
        self
    }

    /// Em^out: an event output of the composite.
    pub fn event_out(&mut self, name: impl Into<String>) -> &mut Self {
        self.outputs.push((PortKind::Event, name.into()));
        self
    }

    /// Ic: a condition leads from an output of a part, or an input of this composite, to an input of a part, or an
    /// output of this composite.
    pub fn condition(&mut self, from: impl Into<Endpoint>, to: impl Into<Endpoint>) -> &mut Self {
        self.links.push((PortKind::Condition, from.into(), to.into()));
        self
    }

    /// Ie: an event leads from one port to the other.
    pub fn event(&mut self, from: impl Into<Endpoint>, to: impl Into<Endpoint>) -> &mut Self {
        self.links.push((PortKind::Event, from.into(), to.into()));
        self
    }

    /// The flat system: each node is named by the way to it, `part.node` or `outer.inner.node`. Or all errors of the
    /// composition; those of the nets and tables are reported once the ports are right.
    pub fn flatten(&self, semantics: Semantics) -> Result<Tnces, Vec<ComposeError>> {
        flatten::flatten(self, semantics)
    }
}
