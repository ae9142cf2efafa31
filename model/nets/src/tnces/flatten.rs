//! From a composite to a flat system.
//!
//! Twice through the tree of parts: upwards, to number the nodes and to find which place or transitions are behind each
//! output; downwards, to carry these to the inputs and turn them into condition and event arcs. Ports leave no trace in
//! the result.

use std::collections::{BTreeMap, HashMap};

use super::check::port_name;
use super::compose::{ComponentId, Composite, Element, Endpoint, PortKind};
use super::{ComposeError, Semantics, Tnces, TncesBuilder, TncesModule};
use crate::{NetBuilder, PlaceId, TransitionId};

/// Deeper than any drawing, and far from the end of the stack.
const DEPTH_MAX: usize = 64;

/// Source behind a port.
#[derive(Clone, Debug)]
enum PortSource {
    Place(PlaceId),
    Transitions(Vec<TransitionId>),
}

type PortSources = HashMap<(PortKind, String), PortSource>;

/// An element with its place in the flat net.
pub(super) struct FlatNode<'a> {
    pub(super) element: &'a Element,
    pub(super) path: String,
    children: Vec<FlatNode<'a>>,
    first_place: u32,
    first_transition: u32,
    outputs: PortSources,
}

pub(super) fn flatten(composite: &Composite, semantics: Semantics) -> Result<Tnces, Vec<ComposeError>> {
    let mut flat = Flattening::default();
    let top = Element::Composite(composite.clone());
    for (kind, port) in &composite.inputs {
        let port = port_name(&composite.name, *kind, "input", port);
        flat.problems.push(ComposeError::NotConnected { port });
    }
    let node = flat.up(&top, String::new(), 0);
    if !flat.problems.is_empty() {
        return Err(flat.problems);
    }
    flat.down(&node, &PortSources::new());
    let Flattening { modules, conditions, events, .. } = flat;
    build(&composite.name, &modules, conditions, events, semantics)
}

#[derive(Default)]
pub(super) struct Flattening<'a> {
    pub(super) problems: Vec<ComposeError>,
    /// With path, first place and first transition.
    modules: Vec<(&'a TncesModule, String, u32, u32)>,
    places: u32,
    transitions: u32,
    conditions: BTreeMap<(TransitionId, PlaceId), u32>,
    events: BTreeMap<TransitionId, Vec<Vec<TransitionId>>>,
}

impl<'a> Flattening<'a> {
    fn up(&mut self, element: &'a Element, path: String, depth: usize) -> FlatNode<'a> {
        match element {
            Element::Module(module) => self.up_module(element, module, path),
            Element::Composite(composite) => {
                let mut children = Vec::new();
                if depth > DEPTH_MAX {
                    self.problems.push(ComposeError::TooDeep { composite: composite.name.clone(), limit: DEPTH_MAX });
                } else {
                    for part in &composite.parts {
                        let dot = if path.is_empty() { "" } else { "." };
                        children.push(self.up(part, format!("{path}{dot}{}", part.name()), depth + 1));
                    }
                    self.check_names(composite);
                    self.check_links(composite, &children);
                }
                let mut node = FlatNode {
                    element,
                    path,
                    children,
                    first_place: 0,
                    first_transition: 0,
                    outputs: PortSources::new(),
                };
                node.outputs = outputs(composite, &node);
                node
            }
        }
    }

    fn up_module(&mut self, element: &'a Element, module: &'a TncesModule, path: String) -> FlatNode<'a> {
        let (first_place, first_transition) = (self.places, self.transitions);
        self.places = self.places.saturating_add(u32::try_from(module.places.len()).unwrap_or(u32::MAX));
        self.transitions = self.transitions.saturating_add(u32::try_from(module.transitions.len()).unwrap_or(u32::MAX));
        self.modules.push((module, path.clone(), first_place, first_transition));
        self.check_module(module, &path);
        let conditions = module.condition_out.iter().map(|(name, place)| {
            ((PortKind::Condition, name.clone()), PortSource::Place(PlaceId(first_place.saturating_add(place.0))))
        });
        let events = module.event_out.iter().map(|(name, transitions)| {
            let flat = transitions.iter().map(|t| TransitionId(first_transition.saturating_add(t.0)));
            ((PortKind::Event, name.clone()), PortSource::Transitions(flat.collect()))
        });
        let outputs = conditions.chain(events).collect();
        FlatNode { element, path, children: Vec::new(), first_place, first_transition, outputs }
    }

    fn down(&mut self, node: &FlatNode, inputs: &PortSources) {
        let composite = match node.element {
            Element::Module(module) => return self.down_module(module, node, inputs),
            Element::Composite(composite) => composite,
        };
        for (part, child) in node.children.iter().enumerate() {
            let mut into = PortSources::new();
            for (kind, from, to) in &composite.links {
                let Endpoint::Of(ComponentId(to), port) = to else { continue };
                if *to != part {
                    continue;
                }
                let signal = match from {
                    Endpoint::Own(name) => inputs.get(&(*kind, name.clone())),
                    Endpoint::Of(ComponentId(from), name) => node.children[*from].outputs.get(&(*kind, name.clone())),
                };
                merge(&mut into, (*kind, port.clone()), signal);
            }
            self.down(child, &into);
        }
    }

    fn down_module(&mut self, module: &TncesModule, node: &FlatNode, inputs: &PortSources) {
        let (p0, t0) = (node.first_place, node.first_transition);
        let flat = |t: TransitionId| TransitionId(t0 + t.0);
        for &(t, p, weight) in &module.conditions {
            self.condition(flat(t), PlaceId(p0 + p.0), weight);
        }
        for (name, transitions) in &module.condition_in {
            if let Some(&PortSource::Place(place)) = inputs.get(&(PortKind::Condition, name.clone())) {
                transitions.iter().for_each(|&t| self.condition(flat(t), place, 1));
            }
        }
        for &(from, to) in &module.events {
            self.events.entry(flat(to)).or_default().push(vec![flat(from)]);
        }
        for (name, transitions) in &module.event_in {
            if let Some(PortSource::Transitions(from)) = inputs.get(&(PortKind::Event, name.clone())) {
                for &to in transitions {
                    self.events.entry(flat(to)).or_default().push(from.clone());
                }
            }
        }
    }

    /// Two ports may carry the same place to one transition: the stronger demand counts.
    fn condition(&mut self, t: TransitionId, place: PlaceId, weight: u32) {
        let known = self.conditions.entry((t, place)).or_insert(weight);
        *known = weight.max(*known);
    }
}

/// Sources behind the outputs of a composite whose parts are flattened.
fn outputs(composite: &Composite, node: &FlatNode) -> PortSources {
    let mut outputs = PortSources::new();
    for (kind, from, to) in &composite.links {
        if let (Endpoint::Of(ComponentId(from), name), Endpoint::Own(port)) = (from, to) {
            let signal = node.children.get(*from).and_then(|child| child.outputs.get(&(*kind, name.clone())));
            merge(&mut outputs, (*kind, port.clone()), signal);
        }
    }
    outputs
}

/// Several event sources of one port are one signal: any of them.
fn merge(into: &mut PortSources, port: (PortKind, String), signal: Option<&PortSource>) {
    let Some(signal) = signal else { return };
    match (into.get_mut(&port), signal) {
        (Some(PortSource::Transitions(all)), PortSource::Transitions(more)) => {
            all.extend(more);
            all.sort_unstable();
            all.dedup();
        }
        _ => _ = into.insert(port, signal.clone()),
    }
}

fn build(
    name: &str,
    modules: &[(&TncesModule, String, u32, u32)],
    conditions: BTreeMap<(TransitionId, PlaceId), u32>,
    events: BTreeMap<TransitionId, Vec<Vec<TransitionId>>>,
    semantics: Semantics,
) -> Result<Tnces, Vec<ComposeError>> {
    let all = |problems: Vec<_>| problems.into_iter().map(ComposeError::Net).collect::<Vec<_>>();
    let mut b = NetBuilder::new(name);
    for (module, path, p0, t0) in modules {
        module.places.iter().for_each(|(name, tokens, _)| _ = b.place(format!("{path}.{name}"), *tokens));
        module.transitions.iter().for_each(|name| _ = b.transition(format!("{path}.{name}")));
        for (t, p, weight) in &module.inputs {
            b.input(TransitionId(t0 + t.0), PlaceId(p0 + p.0), *weight);
        }
        for (t, p, weight) in &module.outputs {
            b.output(TransitionId(t0 + t.0), PlaceId(p0 + p.0), *weight);
        }
    }
    let mut b = TncesBuilder::new(b.build().map_err(all)?);
    b.semantics(semantics);
    for (module, _, p0, t0) in modules {
        for (place, (_, _, age)) in (*p0..).zip(&module.places) {
            b.initial_age(PlaceId(place), *age);
        }
        for (t, p, interval) in &module.intervals {
            b.interval(TransitionId(t0 + t.0), PlaceId(p0 + p.0), *interval);
        }
        module.modes.iter().for_each(|&(t, mode)| _ = b.event_mode(TransitionId(t0 + t.0), mode));
        module.external.iter().for_each(|t| _ = b.external(TransitionId(t0 + t.0)));
    }
    for ((t, p), weight) in conditions {
        b.condition(t, p, weight);
    }
    for (to, mut signals) in events {
        signals.sort_unstable();
        // Two ports with the same source call at the same time.
        signals.dedup();
        signals.into_iter().for_each(|from| _ = b.event_of(from, to));
    }
    b.build().map_err(|problems| problems.into_iter().map(ComposeError::Tnces).collect())
}
