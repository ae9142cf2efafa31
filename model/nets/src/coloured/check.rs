//! The rules that a coloured net is checked against: domains, and the functions and guards that live on them.

use super::bind::BindingOrder;
use super::builder::{ColouredBuilder, DeclaredColouredArc, repeated, show};
use super::domain::{BasicDomain, BasicId, Domain, DomainShape, show_domain};
use super::error::ColouredError;
use super::guard::{self, Case, GuardFault, GuardOperand, MAX_CLAUSES};
use super::linear::{LinearFunction, compile};
use super::net::{ColouredArc, ColouredPlace, ColouredTransition};
use crate::{ArcDirection, ArcName, MAX_NODES, NamedId, NetNode, PlaceId, TransitionId};

/// The most components of a domain. The search for modes nests as deep; the source uses up to five.
pub const MAX_COMPONENTS: usize = 64;

/// Basic domains: not empty, named apart, with tones that are named apart.
pub(super) fn basics(basics: &[BasicDomain], problems: &mut Vec<ColouredError>) {
    for name in repeated(basics.iter().map(|basic| &basic.name)) {
        problems.push(ColouredError::DuplicateName { what: "colour domains", name });
    }
    for BasicDomain { name, size, tones } in basics {
        if *size == 0 {
            problems.push(ColouredError::EmptyBasic { name: name.clone() });
        }
        for tone in repeated(tones.iter()) {
            problems.push(ColouredError::DuplicateTone { name: name.clone(), tone });
        }
        for tone in tones.iter().filter(|tone| tone.is_empty() || tone.contains(['<', '>', ','])) {
            problems.push(ColouredError::ToneName { name: name.clone(), tone: tone.clone() });
        }
    }
}

/// The domains of places and transitions, where they make sense.
pub(super) struct Resolved {
    pub(super) places: Vec<Option<ColouredPlace>>,
    /// Per transition its declared domain, and whether that is the universal one.
    domains: Vec<Option<(Vec<BasicId>, bool)>>,
}

impl Resolved {
    pub(super) fn new(b: &ColouredBuilder, problems: &mut Vec<ColouredError>) -> Resolved {
        let mut places = Vec::with_capacity(b.places.len());
        let mut cells = 0_u32;
        for ((name, domain, max_tokens), id) in b.places.iter().zip(0..) {
            let named = NamedId { id: PlaceId(id), name: name.clone() };
            let node = NamedId { id: NetNode::Place(PlaceId(id)), name: name.clone() };
            let place = components(domain, node, &b.basics, true, problems).and_then(|basics| {
                let Some(shape) = DomainShape::new(&basics, &b.basics) else {
                    problems.push(ColouredError::TooManyColours { place: named.clone() });
                    return None;
                };
                let offset = cells;
                let Some(more) = cells.checked_add(shape.count) else {
                    problems.push(ColouredError::TooManyCells { place: named });
                    return None;
                };
                cells = more;
                Some(ColouredPlace { name: name.clone(), shape, offset, max_tokens: *max_tokens })
            });
            places.push(place);
        }
        let domain = |((name, domain), id): (&(_, Domain), u32)| {
            let node = NamedId { id: NetNode::Transition(TransitionId(id)), name: std::sync::Arc::clone(name) };
            let universal = matches!(domain, Domain::Universal);
            Some((components(domain, node, &b.basics, !universal, problems)?, universal))
        };
        let domains = b.transitions.iter().zip(0..).map(domain).collect();
        Resolved { places, domains }
    }
}

/// The basic domains of a domain, unless one of them does not exist or has no tones.
fn components(
    domain: &Domain,
    node: NamedId<NetNode>,
    all: &[BasicDomain],
    bounded: bool,
    problems: &mut Vec<ColouredError>,
) -> Option<Vec<BasicId>> {
    let basics = match domain {
        Domain::Uncoloured => Vec::new(),
        Domain::Product(basics) => basics.clone(),
        Domain::Universal => (0..all.len() as u32).map(BasicId).collect(),
    };
    let before = problems.len();
    for basic in basics.iter().filter(|basic| basic.index() >= all.len()) {
        let basics = all.len();
        problems.push(ColouredError::UnknownBasic { node: node.clone(), basic: basic.0, basics });
    }
    if bounded && basics.len() > MAX_COMPONENTS {
        let components = basics.len();
        problems.push(ColouredError::TooManyComponents { node, components, most: MAX_COMPONENTS });
    }
    // A domain without a tone has been reported where it is declared.
    let sound = problems.len() == before && basics.iter().all(|basic| all[basic.index()].size > 0);
    sound.then_some(basics)
}

/// A token that is no colour of its place.
pub(super) fn misfit(id: PlaceId, place: &ColouredPlace, tones: &[u32], all: &[BasicDomain]) -> ColouredError {
    let (named, token) = (NamedId { id, name: place.name.clone() }, show(tones));
    let wrong = tones.iter().zip(&place.shape.sizes).position(|(tone, size)| !(1..=*size).contains(tone));
    match wrong.filter(|_| tones.len() == place.shape.sizes.len()) {
        Some(at) => ColouredError::TokenTone { token, place: named, component: at + 1, size: place.shape.sizes[at] },
        None => ColouredError::TokenArity { token, place: named, domain: show_domain(&place.shape.basics, all) },
    }
}

/// All transitions with their arcs and guards, where they make sense.
pub(super) fn transitions(
    b: &ColouredBuilder,
    resolved: &Resolved,
    problems: &mut Vec<ColouredError>,
) -> Vec<Option<ColouredTransition>> {
    let mut sides: Vec<[Vec<ColouredArc>; 2]> = b.transitions.iter().map(|_| Default::default()).collect();
    arcs(b, resolved, &mut sides, problems);
    let mut guards = guards(b, resolved, problems);
    let mut found = Vec::with_capacity(sides.len());
    for (at, [inputs, outputs]) in sides.into_iter().enumerate() {
        let Some((domain, universal)) = &resolved.domains[at] else {
            found.push(None);
            continue;
        };
        let name = b.transitions[at].0.clone();
        let id = TransitionId(at as u32);
        let raw = CheckedTransition { name, id, domain: domain.clone(), inputs, outputs, guard: guards[at].take() };
        found.push(raw.finish(*universal, &b.basics, problems));
    }
    found
}

fn arcs(
    b: &ColouredBuilder,
    resolved: &Resolved,
    sides: &mut [[Vec<ColouredArc>; 2]],
    problems: &mut Vec<ColouredError>,
) {
    let mut order: Vec<&DeclaredColouredArc> = b.arcs.iter().collect();
    let ends = |arc: &DeclaredColouredArc| (arc.direction, arc.transition, arc.place);
    order.sort_by_key(|arc| ends(arc));
    for same in order.chunk_by(|one, other| ends(one) == ends(other)) {
        let arc = arc_name(b, same[0]);
        if same.len() > 1 {
            problems.push(ColouredError::DuplicateArc { arc: arc.clone(), times: same.len() });
        }
        let DeclaredColouredArc { direction, place, transition, .. } = *same[0];
        let what = || format!("the arc {arc}");
        if place.index() >= b.places.len() {
            let places = b.places.len();
            problems.push(ColouredError::UnknownPlace { what: what(), place: place.0, places });
        }
        if transition.index() >= b.transitions.len() {
            let transitions = b.transitions.len();
            problems.push(ColouredError::UnknownTransition { what: what(), transition: transition.0, transitions });
        }
        let of_place = resolved.places.get(place.index()).and_then(Option::as_ref);
        let of_transition = resolved.domains.get(transition.index()).and_then(Option::as_ref);
        let (Some(of_place), Some((domain, _))) = (of_place, of_transition) else { continue };
        for raw in same {
            match meaning(raw, &arc, domain, of_place, &b.basics) {
                Ok(linear) => {
                    let side = usize::from(direction == ArcDirection::Output);
                    sides[transition.index()][side].push(ColouredArc { place, terms: linear.terms });
                }
                Err(problem) => problems.push(*problem),
            }
        }
    }
}

/// Meaning of an arc's function, if it moves a positive number of tokens of the place's domain.
fn meaning(
    raw: &DeclaredColouredArc,
    arc: &ArcName,
    domain: &[BasicId],
    place: &ColouredPlace,
    all: &[BasicDomain],
) -> Result<LinearFunction, Box<ColouredError>> {
    let (arc, function) = (arc.clone(), raw.function.to_string());
    let linear = match compile(&raw.function, domain, all) {
        Ok(linear) => linear,
        Err(error) => return Err(Box::new(ColouredError::Function { arc, function, error })),
    };
    if *linear.target != *place.shape.basics {
        let (found, expected) = (show_domain(&linear.target, all), show_domain(&place.shape.basics, all));
        return Err(Box::new(ColouredError::ArcDomain { arc, function, found, expected }));
    }
    let counted = |weight: i64| u32::try_from(weight).is_ok_and(|weight| weight > 0);
    if linear.terms.is_empty() {
        return Err(Box::new(ColouredError::Weight { arc, function, weight: 0 }));
    }
    if let Some(term) = linear.terms.iter().find(|term| !counted(term.weight)) {
        return Err(Box::new(ColouredError::Weight { arc, function, weight: term.weight }));
    }
    // The terms number a few thousand at most, so this sum is far from the end of 64 bits.
    if !counted(linear.terms.iter().map(|term| term.weight).sum()) {
        return Err(Box::new(ColouredError::Weights { arc, function }));
    }
    Ok(linear)
}

fn guards(b: &ColouredBuilder, resolved: &Resolved, problems: &mut Vec<ColouredError>) -> Vec<Option<Vec<Case>>> {
    let mut found: Vec<Option<Vec<Case>>> = vec![None; b.transitions.len()];
    for (id, guard) in &b.guards {
        let Some((name, _)) = b.transitions.get(id.index()) else {
            let transitions = b.transitions.len();
            let what = "a guard".to_owned();
            problems.push(ColouredError::UnknownTransition { what, transition: id.0, transitions });
            continue;
        };
        let transition = NamedId { id: *id, name: name.clone() };
        if guard.clauses.is_empty() {
            problems.push(ColouredError::EmptyGuard { transition: transition.clone() });
        }
        if found[id.index()].is_some() {
            problems.push(ColouredError::DuplicateGuard { transition: transition.clone() });
        }
        let sizes = guard.clauses.iter().map(|clause| clause.atoms.len()).chain([guard.clauses.len()]);
        if sizes.max() > Some(MAX_CLAUSES) {
            problems.push(ColouredError::TooManyClauses { transition });
            continue;
        }
        let Some((domain, _)) = &resolved.domains[id.index()] else { continue };
        match guard::compile(guard, domain, &b.basics) {
            Ok(cases) => found[id.index()] = Some(cases),
            Err(faults) => problems.extend(faults.into_iter().map(|fault| match fault {
                GuardFault::NoComponent { component } => {
                    let domain = show_domain(domain, &b.basics);
                    ColouredError::GuardComponent { transition: transition.clone(), component, domain }
                }
                GuardFault::NoTone { component, number, size } => {
                    ColouredError::GuardTone { transition: transition.clone(), component, number, size }
                }
            })),
        }
    }
    found
}

/// A transition whose arcs and guard have a meaning; its domain may still be wider than it needs.
pub(super) struct CheckedTransition {
    pub(super) name: std::sync::Arc<str>,
    pub(super) id: TransitionId,
    pub(super) domain: Vec<BasicId>,
    pub(super) inputs: Vec<ColouredArc>,
    pub(super) outputs: Vec<ColouredArc>,
    pub(super) guard: Option<Vec<Case>>,
}

impl CheckedTransition {
    /// Drops what is not used, on request, and bounds the number of modes.
    pub(super) fn finish(
        mut self,
        restrict: bool,
        all: &[BasicDomain],
        problems: &mut Vec<ColouredError>,
    ) -> Option<ColouredTransition> {
        if restrict {
            self.restrict();
        }
        let CheckedTransition { name, id, domain, inputs, outputs, guard } = self;
        if domain.len() > MAX_COMPONENTS {
            let node = NamedId { id: NetNode::Transition(id), name };
            problems.push(ColouredError::TooManyComponents { node, components: domain.len(), most: MAX_COMPONENTS });
            return None;
        }
        let Some(shape) = DomainShape::new(&domain, all).filter(|shape| shape.count as usize <= MAX_NODES) else {
            problems.push(ColouredError::TooManyModes { transition: NamedId { id, name } });
            return None;
        };
        let plan = BindingOrder::new(&inputs, domain.len());
        Some(ColouredTransition { name, shape, inputs, outputs, guard, plan })
    }

    /// Keeps the components that an arc or the guard reads.
    fn restrict(&mut self) {
        let mut used = vec![false; self.domain.len()];
        self.each_component(|component| used[*component as usize] = true);
        let mut number = vec![0; used.len()];
        let mut kept = Vec::new();
        for (at, _) in used.iter().enumerate().filter(|(_, used)| **used) {
            number[at] = kept.len() as u32;
            kept.push(self.domain[at]);
        }
        self.each_component(|component| *component = number[*component as usize]);
        self.domain = kept;
    }

    /// Every mention of a component of the mode.
    pub(super) fn each_component(&mut self, mut visit: impl FnMut(&mut u32)) {
        let sides = self.inputs.iter_mut().chain(&mut self.outputs);
        for pick in sides.flat_map(|side| &mut side.terms).flat_map(|term| &mut term.picks) {
            visit(&mut pick.from);
        }
        let tests = self.guard.iter_mut().flatten().flat_map(|case| &mut case.tests);
        for value in tests.flat_map(|test| test.values_mut()) {
            if let GuardOperand::Component { from, .. } = value {
                visit(from);
            }
        }
    }
}

/// An arc with the names of its ends; an end that was never declared is shown by its number.
fn arc_name(b: &ColouredBuilder, arc: &DeclaredColouredArc) -> ArcName {
    let place = b.places.get(arc.place.index()).map(|(name, ..)| name.clone());
    let transition = b.transitions.get(arc.transition.index()).map(|(name, _)| name.clone());
    ArcName {
        direction: arc.direction,
        place: NamedId { id: arc.place, name: place.unwrap_or_else(|| format!("#{}", arc.place.0).into()) },
        transition: NamedId {
            id: arc.transition,
            name: transition.unwrap_or_else(|| format!("#{}", arc.transition.0).into()),
        },
    }
}
