//! Errors in the ports and connections of a composition, with the way to each port.

use std::collections::{BTreeMap, HashSet};

use super::compose::{ComponentId, Composite, Element, Endpoint, PortKind};
use super::flatten::{FlatNode, Flattening};
use super::{ComposeError, TncesModule};

impl Flattening<'_> {
    pub(super) fn check_module(&mut self, module: &TncesModule, path: &str) {
        let ports = module.condition_in.iter().map(|(name, _)| (PortKind::Condition, name));
        let ports = ports.chain(module.event_in.iter().map(|(name, _)| (PortKind::Event, name)));
        self.check_ports(path, "inputs", ports);
        let ports = module.condition_out.iter().map(|(name, _)| (PortKind::Condition, name));
        let ports = ports.chain(module.event_out.iter().map(|(name, _)| (PortKind::Event, name)));
        self.check_ports(path, "outputs", ports);
        for (kind, ports) in [(PortKind::Condition, &module.condition_in), (PortKind::Event, &module.event_in)] {
            for (name, _) in ports.iter().filter(|(_, transitions)| transitions.is_empty()) {
                self.problems.push(ComposeError::Idle { port: port_name(path, kind, "input", name) });
            }
        }
        let arcs = module.inputs.iter().chain(&module.outputs).chain(&module.conditions);
        let places = arcs.clone().map(|&(_, p, _)| p).chain(module.condition_out.iter().map(|&(_, p)| p));
        let transitions = arcs.map(|&(t, _, _)| t);
        let transitions = transitions.chain(module.events.iter().flat_map(|&(from, to)| [from, to]));
        let transitions =
            transitions.chain(module.modes.iter().map(|&(t, _)| t)).chain(module.external.iter().copied());
        let ports = module.condition_in.iter().chain(&module.event_in).chain(&module.event_out);
        let transitions = transitions.chain(ports.flat_map(|(_, transitions)| transitions.iter().copied()));
        let foreign = |nodes, count, id| ComposeError::ForeignId { module: path.to_owned(), nodes, count, id };
        let (p_count, t_count) = (module.places.len(), module.transitions.len());
        let place = places.filter(|p| p.index() >= p_count).min().map(|p| foreign("places", p_count, p.0));
        let transition = transitions.filter(|t| t.index() >= t_count).min();
        self.problems.extend(place);
        self.problems.extend(transition.map(|t| foreign("transitions", t_count, t.0)));
    }

    fn check_ports<'n>(&mut self, owner: &str, way: &str, ports: impl Iterator<Item = (PortKind, &'n String)>) {
        let mut known = HashSet::new();
        for (kind, name) in ports.filter(|&port| !known.insert(port)) {
            let port = format!("{} {way} named `{name}`", kind.word());
            self.problems.push(ComposeError::DuplicatePort { owner: owner.to_owned(), port });
        }
    }

    pub(super) fn check_names(&mut self, composite: &Composite) {
        let mut known = HashSet::new();
        for part in composite.parts.iter().filter(|part| !known.insert(part.name())) {
            let (composite, name) = (composite.name.clone(), part.name().to_owned());
            self.problems.push(ComposeError::DuplicatePart { composite, name });
        }
        self.check_ports(&composite.name, "inputs", composite.inputs.iter().map(|(kind, name)| (*kind, name)));
        self.check_ports(&composite.name, "outputs", composite.outputs.iter().map(|(kind, name)| (*kind, name)));
    }

    pub(super) fn check_links(&mut self, composite: &Composite, children: &[FlatNode]) {
        // By the driven port.
        let mut sources: BTreeMap<(PortKind, Endpoint), Vec<&Endpoint>> = BTreeMap::new();
        for (kind, from, to) in &composite.links {
            let found = self.check_end(composite, children, *kind, from, true);
            if self.check_end(composite, children, *kind, to, false) && found {
                sources.entry((*kind, to.clone())).or_default().push(from);
            }
            if let (Endpoint::Own(from), Endpoint::Own(to)) = (from, to) {
                let (from, to) = (from.clone(), to.clone());
                self.problems.push(ComposeError::PassThrough { composite: composite.name.clone(), from, to });
            }
        }
        let port = |kind: PortKind, end: &Endpoint| match end {
            Endpoint::Own(name) => port_name(&composite.name, kind, "output", name),
            Endpoint::Of(part, name) => port_name(&children[part.0].path, kind, "input", name),
        };
        for ((kind, to), from) in &sources {
            let different: HashSet<&Endpoint> = from.iter().copied().collect();
            if from.len() > different.len() || (*kind == PortKind::Condition && from.len() > 1) {
                let name = |end: &&Endpoint| match end {
                    Endpoint::Own(name) => format!("`{}.{name}`", composite.name),
                    Endpoint::Of(part, name) => format!("`{}.{name}`", children[part.0].path),
                };
                let names: Vec<_> = from.iter().map(name).collect();
                let (port, times) = (port(*kind, to), from.len());
                self.problems.push(ComposeError::DoubleConnection { port, times, sources: names.join(", ") });
            }
        }
        let inner = children.iter().enumerate().flat_map(|(part, child)| {
            inputs(child.element)
                .into_iter()
                .map(move |(kind, name)| (kind, Endpoint::Of(ComponentId(part), name.to_owned())))
        });
        let own = composite.outputs.iter().map(|(kind, name)| (*kind, Endpoint::Own(name.clone())));
        for (kind, end) in inner.chain(own).filter(|driven| !sources.contains_key(driven)) {
            self.problems.push(ComposeError::NotConnected { port: port(kind, &end) });
        }
        let used: HashSet<(PortKind, &Endpoint)> =
            composite.links.iter().map(|(kind, from, _)| (*kind, from)).collect();
        for (kind, name) in
            composite.inputs.iter().filter(|(kind, name)| !used.contains(&(*kind, &Endpoint::Own(name.clone()))))
        {
            self.problems.push(ComposeError::Idle { port: port_name(&composite.name, *kind, "input", name) });
        }
    }

    /// Whether an end exists. A source is an output of a part or an input of the composite.
    fn check_end(
        &mut self,
        composite: &Composite,
        children: &[FlatNode],
        kind: PortKind,
        end: &Endpoint,
        is_source: bool,
    ) -> bool {
        let (owner, exists, way, name) = match end {
            Endpoint::Own(name) => {
                let own = if is_source { &composite.inputs } else { &composite.outputs };
                let exists = own.iter().any(|port| *port == (kind, name.clone()));
                (&composite.name, exists, if is_source { "input" } else { "output" }, name)
            }
            Endpoint::Of(part, name) => {
                let Some(child) = children.get(part.0) else {
                    let (composite, parts) = (composite.name.clone(), children.len());
                    self.problems.push(ComposeError::UnknownPart { composite, part: part.0, parts });
                    return false;
                };
                let ports = if is_source { outputs_named(child.element) } else { inputs(child.element) };
                let way = if is_source { "output" } else { "input" };
                (&child.path, ports.contains(&(kind, name)), way, name)
            }
        };
        if !exists {
            let port = format!("{} {way} `{name}`", kind.word());
            self.problems.push(ComposeError::UnknownPort { owner: owner.clone(), port });
        }
        exists
    }
}

fn inputs(element: &Element) -> Vec<(PortKind, &String)> {
    match element {
        Element::Module(module) => {
            let conditions = module.condition_in.iter().map(|(name, _)| (PortKind::Condition, name));
            conditions.chain(module.event_in.iter().map(|(name, _)| (PortKind::Event, name))).collect()
        }
        Element::Composite(composite) => composite.inputs.iter().map(|(kind, name)| (*kind, name)).collect(),
    }
}

fn outputs_named(element: &Element) -> Vec<(PortKind, &String)> {
    match element {
        Element::Module(module) => {
            let conditions = module.condition_out.iter().map(|(name, _)| (PortKind::Condition, name));
            conditions.chain(module.event_out.iter().map(|(name, _)| (PortKind::Event, name))).collect()
        }
        Element::Composite(composite) => composite.outputs.iter().map(|(kind, name)| (*kind, name)).collect(),
    }
}

pub(super) fn port_name(owner: &str, kind: PortKind, way: &str, port: &str) -> String {
    format!("{} {way} `{owner}.{port}`", kind.word())
}
