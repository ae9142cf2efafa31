//! Nets put together by fusing transitions.
//!
//! A resource is modelled once, as a small net whose *port transitions* are what it does together with others; a cell is
//! several of them, with ports fused (seed 000, L1420-1422). A fused transition fires in a mode only if all its parts
//! can, and changes what they change together. Parts agree on the components of the mode by their basic domains: a basic
//! domain of the same name is the same domain, and its first occurrence in one part is its first occurrence in every
//! other. A guard that several parts share is one guard.
//!
//! Places and transitions that are not fused keep apart: they are called `robot.free`, by the name that the instance of
//! the net has here.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::builder::repeated;
use super::check::CheckedTransition;
use super::domain::{BasicDomain, BasicId};
use super::error::ColouredError;
use super::guard::{Case, MAX_CLAUSES};
use super::linear;
use super::marking::ColouredMarking;
use super::net::{ColouredArc, ColouredNet, ColouredPlace};
use crate::{ArcDirection, ArcName, NamedId, PlaceId, TransitionId};

/// Transitions that happen together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fusion {
    name: Arc<str>,
    /// The number of the net, from 0, and the transition's name in it.
    parts: Vec<(usize, String)>,
}

impl Fusion {
    /// A fused transition of that name, of these parts: the number of the net in the list, and the transition's name.
    pub fn new<N: Into<String>>(name: impl Into<String>, parts: impl IntoIterator<Item = (usize, N)>) -> Fusion {
        let parts = parts.into_iter().map(|(net, transition)| (net, transition.into())).collect();
        Fusion { name: name.into().into(), parts }
    }
}

/// Puts nets together, each under a name of its own, so that a net can be there more than once.
///
/// Returns everything that does not fit. Fused transitions come first, in their order; then what is left of each net.
pub fn fuse(
    name: impl Into<String>,
    nets: &[(&str, &ColouredNet)],
    fusions: &[Fusion],
) -> Result<ColouredNet, Vec<ColouredError>> {
    let mut problems = Vec::new();
    let basics = unite(nets, &mut problems);
    let parts = find_parts(nets, fusions, &mut problems);
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut whole = FusedNet { nets, basics, places: Vec::new(), first_place: Vec::new(), tokens: Vec::new() };
    whole.join_places(&mut problems);
    let mut raws = Vec::new();
    for (fusion, parts) in fusions.iter().zip(&parts) {
        raws.push(whole.transition(fusion.name.clone(), parts, raws.len(), &mut problems));
    }
    for (at, (instance, net)) in nets.iter().enumerate() {
        for t in net.transitions().filter(|&t| !parts.iter().flatten().any(|&part| part == (at, t))) {
            let name = format!("{instance}.{}", net.transition(t).name).into();
            raws.push(whole.transition(name, &[(at, t)], raws.len(), &mut problems));
        }
    }
    let of_places = whole.places.iter().map(|place| &place.name);
    problems.extend(repeated(of_places).into_iter().map(|name| ColouredError::DuplicateName { what: "places", name }));
    let of_raws = raws.iter().flatten().map(|raw| &raw.name);
    let twice = |name| ColouredError::DuplicateName { what: "transitions", name };
    problems.extend(repeated(of_raws).into_iter().map(twice));
    let like_colour = raws.iter().flatten().filter(|raw| raw.name.ends_with('>'));
    problems.extend(
        like_colour
            .map(|raw| ColouredError::NameLikeColour { node: NamedId { id: raw.id.into(), name: raw.name.clone() } }),
    );
    let finish = |raw: CheckedTransition| raw.finish(false, &whole.basics, &mut problems);
    let transitions: Vec<_> = raws.into_iter().flatten().filter_map(finish).collect();
    if !problems.is_empty() {
        return Err(problems);
    }
    let initial = ColouredMarking { entries: whole.tokens };
    Ok(ColouredNet::assemble(name.into(), whole.basics, whole.places, transitions, initial))
}

/// All basic domains, each once.
fn unite(nets: &[(&str, &ColouredNet)], problems: &mut Vec<ColouredError>) -> Vec<BasicDomain> {
    let mut all: Vec<(BasicDomain, &str)> = Vec::new();
    for (instance, net) in nets {
        for basic in net.basics() {
            match all.iter().find(|(known, _)| known.name == basic.name) {
                None => all.push((basic.clone(), instance)),
                Some((known, _)) if known == basic => {}
                Some((_, other)) => problems.push(ColouredError::BasicsDiffer {
                    name: basic.name.clone(),
                    net: (*instance).to_owned(),
                    other: (*other).to_owned(),
                }),
            }
        }
    }
    all.into_iter().map(|(basic, _)| basic).collect()
}

type FusedPart = (usize, TransitionId);

fn find_parts(
    nets: &[(&str, &ColouredNet)],
    fusions: &[Fusion],
    problems: &mut Vec<ColouredError>,
) -> Vec<Vec<FusedPart>> {
    let mut taken: HashMap<FusedPart, ()> = HashMap::new();
    let mut all = Vec::new();
    for fusion in fusions {
        let mut parts = Vec::new();
        for (net, name) in &fusion.parts {
            let Some(transition) = nets.get(*net).and_then(|(_, net)| net.transition_named(name)) else {
                let (fusion, transition) = (fusion.name.clone(), name.clone());
                problems.push(ColouredError::UnknownPart { fusion, net: *net, transition });
                continue;
            };
            if taken.insert((*net, transition), ()).is_some() {
                problems.push(ColouredError::FusedTwice { net: *net, transition: name.as_str().into() });
            }
            parts.push((*net, transition));
        }
        all.push(parts);
    }
    all
}

/// The net under construction.
struct FusedNet<'a> {
    nets: &'a [(&'a str, &'a ColouredNet)],
    basics: Vec<BasicDomain>,
    places: Vec<ColouredPlace>,
    /// Where the places of each net begin.
    first_place: Vec<usize>,
    tokens: Vec<(u32, u32)>,
}

impl FusedNet<'_> {
    /// The place of all places in one list, with their tokens.
    fn join_places(&mut self, problems: &mut Vec<ColouredError>) {
        let mut cells = 0_u32;
        for (instance, net) in self.nets {
            self.first_place.push(self.places.len());
            let base = cells;
            let Some(more) = cells.checked_add(net.cell_count()) else {
                let id = PlaceId(self.places.len() as u32);
                problems.push(ColouredError::TooManyCells { place: NamedId { id, name: (*instance).into() } });
                return;
            };
            cells = more;
            for place in &net.places {
                let mut place = place.clone();
                place.name = format!("{instance}.{}", place.name).into();
                place.offset += base;
                place.shape.basics = place.shape.basics.iter().map(|&basic| self.basic(net, basic)).collect();
                self.places.push(place);
            }
            self.tokens.extend(net.initial.entries.iter().map(|&(cell, count)| (base + cell, count)));
        }
    }

    /// The basic domain here of one of a net.
    fn basic(&self, net: &ColouredNet, basic: BasicId) -> BasicId {
        let name = net.basics[basic.index()].name();
        let at = self.basics.iter().position(|known| known.name() == name);
        BasicId(at.expect("all domains have been united") as u32)
    }

    /// The transition that all parts together are.
    fn transition(
        &self,
        name: Arc<str>,
        parts: &[FusedPart],
        number: usize,
        problems: &mut Vec<ColouredError>,
    ) -> Option<CheckedTransition> {
        let id = TransitionId(number as u32);
        let mut raw = CheckedTransition {
            name: name.clone(),
            id,
            domain: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            guard: None,
        };
        let mut guards: Vec<Vec<Case>> = Vec::new();
        for &(net, transition) in parts {
            let part = self.part(net, transition, &mut raw.domain);
            raw.inputs.extend(part.inputs);
            raw.outputs.extend(part.outputs);
            guards.extend(part.guard.filter(|guard| !guards.contains(guard)));
        }
        for (direction, sides) in [(ArcDirection::Input, &mut raw.inputs), (ArcDirection::Output, &mut raw.outputs)] {
            if let Err(place) = merge(sides) {
                let place = NamedId { id: place, name: self.places[place.index()].name.clone() };
                let arc = ArcName { direction, place, transition: NamedId { id, name: name.clone() } };
                problems.push(ColouredError::Weights { arc, function: "the sum of its parts".to_owned() });
                return None;
            }
        }
        match conjunction(guards) {
            Some(guard) => raw.guard = guard,
            None => {
                problems.push(ColouredError::TooManyClauses { transition: NamedId { id, name } });
                return None;
            }
        }
        Some(raw)
    }

    /// One part, in terms of the places and of the components of the whole; components that are new are added.
    fn part(&self, net: usize, transition: TransitionId, domain: &mut Vec<BasicId>) -> CheckedTransition {
        let (_, of) = self.nets[net];
        let part = &of.transitions[transition.index()];
        let mut seen: HashMap<BasicId, usize> = HashMap::new();
        let mut component = |basic: BasicId| {
            let basic = self.basic(of, basic);
            let occurrence = seen.entry(basic).or_default();
            *occurrence += 1;
            let same = domain.iter().enumerate().filter(|(_, known)| **known == basic);
            if let Some((at, _)) = same.clone().nth(*occurrence - 1) {
                return at as u32;
            }
            domain.push(basic);
            domain.len() as u32 - 1
        };
        let components: Vec<u32> = part.shape.basics.iter().map(|&basic| component(basic)).collect();
        let first = self.first_place[net] as u32;
        let sides = |sides: &[ColouredArc]| {
            let side =
                |side: &ColouredArc| ColouredArc { place: PlaceId(first + side.place.0), terms: side.terms.clone() };
            sides.iter().map(side).collect()
        };
        let mut raw = CheckedTransition {
            name: part.name.clone(),
            id: transition,
            domain: Vec::new(),
            inputs: sides(&part.inputs),
            outputs: sides(&part.outputs),
            guard: part.guard.clone(),
        };
        raw.each_component(|component| *component = components[*component as usize]);
        raw
    }
}

/// One arc for each place; or the place for which the weights cannot be counted.
fn merge(sides: &mut Vec<ColouredArc>) -> Result<(), PlaceId> {
    let mut by_place: BTreeMap<PlaceId, Vec<linear::LinearTerm>> = BTreeMap::new();
    for side in sides.drain(..) {
        by_place.entry(side.place).or_default().extend(side.terms);
    }
    for (place, terms) in by_place {
        let total: i128 = terms.iter().map(|term| i128::from(term.weight)).sum();
        if total > u32::MAX.into() {
            return Err(place);
        }
        let terms = linear::collect(terms).ok_or(place)?;
        sides.push(ColouredArc { place, terms });
    }
    Ok(())
}

/// All of these guards, multiplied out; none if that has too many clauses.
fn conjunction(guards: Vec<Vec<Case>>) -> Option<Option<Vec<Case>>> {
    let mut all: Option<Vec<Case>> = None;
    for guard in guards {
        all = Some(match all {
            None => guard,
            Some(before) => {
                let long = before.iter().chain(&guard).map(|case| case.tests.len()).max() > Some(MAX_CLAUSES / 2);
                if long || before.len() * guard.len() > MAX_CLAUSES {
                    return None;
                }
                let both = |one: &Case, other: &Case| {
                    let mut tests = one.tests.clone();
                    tests.extend(other.tests.iter().filter(|test| !one.tests.contains(test)));
                    Case { tests, scheduled: one.scheduled || other.scheduled }
                };
                before.iter().flat_map(|one| guard.iter().map(move |other| both(one, other))).collect()
            }
        });
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coloured::{ColouredBuilder, Domain, Guard, colour, id, proj};

    fn store(size: u32) -> ColouredNet {
        let mut b = ColouredBuilder::new("store");
        let part = b.basic("P", size);
        let stock = b.place("stock", part);
        let out = b.transition("out", Domain::Universal);
        b.tokens(stock, &[1], 2).tokens(stock, &[2], 1).input(out, stock, id());
        b.build().unwrap()
    }

    fn machine() -> ColouredNet {
        let mut b = ColouredBuilder::new("machine");
        let (machine, part) = (b.basic("M", 2), b.basic("P", 2));
        let (free, busy) = (b.place("free", machine), b.place("busy", [machine, part]));
        let (load, done) = (b.transition("load", Domain::Universal), b.transition("done", Domain::Universal));
        b.tokens(free, &[1], 1).tokens(free, &[2], 1);
        b.input(load, free, proj([1])).output(load, busy, id()).input(done, busy, id()).output(done, free, proj([1]));
        b.guard(load, Guard::any([[colour(1, 1), colour(2, 1)], [colour(1, 2), colour(2, 2)]]));
        b.build().unwrap()
    }

    #[test]
    fn parts_agree_on_what_they_share() {
        let (store, machine) = (store(2), machine());
        let load = Fusion::new("load", [(0, "out"), (1, "load")]);
        let net = fuse("cell", &[("store", &store), ("cell", &machine)], &[load]).unwrap();
        let expected = "\
coloured net cell: places 3, transitions 2, tokens 5
  colours P = 1..2
  colours M = 1..2
  place store.stock of P = 2*<1> + <2>
  place cell.free of M = <1> + <2>
  place cell.busy of M*P = 0
  transition load of P*M: store.stock <1>, cell.free <2> → cell.busy <2,1>
    if <2> = 1 and <1> = 1 or <2> = 2 and <1> = 2
  transition cell.done of M*P: cell.busy <1,2> → cell.free <1>
";
        assert_eq!(net.to_string(), expected);
        let names: Vec<_> = net.enabled(&net.initial_marking()).iter().map(|&mode| net.mode_name(mode)).collect();
        assert_eq!(names, ["load<1,1>", "load<2,2>"]);
    }

    #[test]
    fn what_does_not_fit_is_reported_together() {
        let (three, machine) = (store(3), machine());
        let fusions = [Fusion::new("load", [(0, "out"), (1, "lode"), (7, "x")]), Fusion::new("again", [(0, "out")])];
        let problems = fuse("cell", &[("a", &three), ("b", &machine)], &fusions).unwrap_err();
        let messages: Vec<_> = problems.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            [
                "colour domain `P` has other tones in net `b` than in `a`",
                "the fusion `load` names transition `lode` of net #1, which does not exist",
                "the fusion `load` names transition `x` of net #7, which does not exist",
                "transition `out` of net #0 takes part in a fusion twice",
            ]
        );
    }

    #[test]
    fn two_instances_of_one_net_need_two_names() {
        let machine = machine();
        assert!(fuse("two", &[("a", &machine), ("b", &machine)], &[]).is_ok());
        let problems = fuse("two", &[("a", &machine), ("a", &machine)], &[]).unwrap_err();
        assert_eq!(problems.len(), 4);
    }
}
