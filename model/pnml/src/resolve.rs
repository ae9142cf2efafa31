//! Draft → net: targets of ids, names, and arcs.

use std::collections::HashMap;

use linewright_nets::{Net, NetBuilder, PlaceId, TransitionId};

use crate::draft::{Being, DraftNet, DraftNode, Id, NodeKind};
use linewright_diagnostics::{At, Problem, Report, shown};

/// The net of a draft; none if there are errors, which are reported.
pub(crate) fn resolve(draft: DraftNet<'_>, report: &mut Report) -> Option<Net> {
    let owners = owners(&draft, report);
    let beings = follow_references(&draft, &owners, report);
    let mut builder = NetBuilder::new(draft.name.as_deref().unwrap_or("net"));
    let nodes = declare(&draft, &mut builder);
    let arcs = arcs(&draft, &owners, &beings, &nodes, report);
    for ((transition, place, is_input), weight) in arcs {
        match is_input {
            true => builder.input(transition, place, weight),
            false => builder.output(transition, place, weight),
        };
    }
    if report.has_errors() {
        return None;
    }
    match builder.build() {
        Ok(net) => Some(net),
        Err(errors) => {
            for error in errors {
                report.add(Problem::error(draft.at, error.to_string()));
            }
            None
        }
    }
}

/// For each id, the node that has it. Two of the same id are reported, arcs included.
fn owners(draft: &DraftNet<'_>, report: &mut Report) -> Vec<Option<u32>> {
    let mut owners = vec![None; draft.ids.len()];
    let mut first: Vec<Option<At>> = vec![None; draft.ids.len()];
    let nodes = draft.nodes.iter().zip(0..).map(|(node, index)| (node.id, node.at, Some(index)));
    let arcs = draft.arcs.iter().filter_map(|arc| Some((arc.id?, arc.at, None)));
    for (id, at, node) in nodes.chain(arcs) {
        match first[id.0 as usize] {
            None => (first[id.0 as usize], owners[id.0 as usize]) = (Some(at), node),
            Some(earlier) => {
                let finding = Problem::error(at, format!("the id `{}` is given twice", text(draft, id)));
                report.add(finding.hint("ids are unique in a file").earlier(earlier));
            }
        }
    }
    owners
}

/// For each node, the node it really is: itself, or the end of its chain of references. None if that is nowhere.
fn follow_references(draft: &DraftNet<'_>, owners: &[Option<u32>], report: &mut Report) -> Vec<Option<u32>> {
    #[derive(Clone, Copy, PartialEq)]
    enum ResolveState {
        Not,
        OnThisWay,
        Known(Option<u32>),
    }
    let mut seen = vec![ResolveState::Not; draft.nodes.len()];
    let mut way: Vec<u32> = Vec::new();
    for start in 0..draft.nodes.len() as u32 {
        let mut at = start;
        let being = loop {
            let node = &draft.nodes[at as usize];
            match (seen[at as usize], &node.is) {
                (ResolveState::Known(being), _) => break being,
                (ResolveState::OnThisWay, _) => {
                    let finding = Problem::error(node.at, format!("`{}` refers to itself", text(draft, node.id)));
                    report.add(finding.hint("a reference leads, over others perhaps, to a node"));
                    break None;
                }
                (ResolveState::Not, Being::Itself { .. }) => break Some(at),
                (ResolveState::Not, Being::Another { id, at: place }) => {
                    seen[at as usize] = ResolveState::OnThisWay;
                    way.push(at);
                    match referred(draft, owners, node, *id, *place, report) {
                        Some(next) => at = next,
                        None => break None,
                    }
                }
            }
        };
        seen[start as usize] = ResolveState::Known(being);
        way.drain(..).for_each(|node| seen[node as usize] = ResolveState::Known(being));
    }
    let known = |seen| if let ResolveState::Known(being) = seen { being } else { None };
    seen.into_iter().map(known).collect()
}

/// The node that a reference names.
fn referred(
    draft: &DraftNet<'_>,
    owners: &[Option<u32>],
    from: &DraftNode,
    to: Id,
    at: At,
    report: &mut Report,
) -> Option<u32> {
    let (kind, name) = (from.kind.word(), text(draft, to));
    let what = match owners[to.0 as usize] {
        Some(node) if draft.nodes[node as usize].kind == from.kind => return Some(node),
        Some(_) => kind,
        None => "node of the net",
    };
    report.add(
        Problem::error(at, format!("`{}` refers to `{name}`, which is no {what}", text(draft, from.id)))
            .hint(format!("write the id of a {kind}")),
    );
    None
}

/// A node of the net.
#[derive(Clone, Copy)]
enum Declared {
    Place(PlaceId),
    Transition(TransitionId),
    Reference,
}

fn declare(draft: &DraftNet<'_>, builder: &mut NetBuilder) -> Vec<Declared> {
    let places = names(draft, NodeKind::Place);
    let transitions = names(draft, NodeKind::Transition);
    let declare = |(index, node): (usize, &DraftNode)| match (&node.is, node.kind) {
        (Being::Another { .. }, _) => Declared::Reference,
        (Being::Itself { tokens, .. }, NodeKind::Place) => {
            Declared::Place(builder.place(places[&(index as u32)], *tokens))
        }
        (Being::Itself { .. }, NodeKind::Transition) => {
            Declared::Transition(builder.transition(transitions[&(index as u32)]))
        }
    };
    draft.nodes.iter().enumerate().map(declare).collect()
}

/// Names of the nodes of a kind: their names, as far as they are unique, and else their ids.
///
/// A node that goes by its id takes the name away from a node that is called the same, and that one goes by its id as
/// well, and so on. Ids are unique, so in the end all names are.
fn names<'d>(draft: &'d DraftNet<'_>, kind: NodeKind) -> HashMap<u32, &'d str> {
    let mut holder: HashMap<&str, Option<u32>> = HashMap::new();
    let mut by_id: Vec<u32> = Vec::new();
    let of_kind = || draft.nodes.iter().zip(0..).filter(|(node, _)| node.kind == kind);
    for (node, index) in of_kind() {
        match &node.is {
            Being::Itself { name: Some(name), .. } => {
                holder.entry(name).and_modify(|holder| by_id.extend(holder.take())).or_insert(Some(index));
                if holder[name.as_str()] != Some(index) {
                    by_id.push(index);
                }
            }
            Being::Itself { name: None, .. } => by_id.push(index),
            Being::Another { .. } => {}
        }
    }
    let mut names = HashMap::new();
    while let Some(index) = by_id.pop() {
        let id = &*draft.ids[draft.nodes[index as usize].id.0 as usize];
        names.insert(index, id);
        by_id.extend(holder.get_mut(id).and_then(Option::take));
    }
    names.extend(holder.into_iter().filter_map(|(name, holder)| Some((holder?, name))));
    names
}

type Joint = (TransitionId, PlaceId, bool);

/// All arcs, parallel ones joined: together they move the sum of their weights.
fn arcs(
    draft: &DraftNet<'_>,
    owners: &[Option<u32>],
    beings: &[Option<u32>],
    nodes: &[Declared],
    report: &mut Report,
) -> HashMap<Joint, u32> {
    let mut arcs: HashMap<Joint, u32> = HashMap::with_capacity(draft.arcs.len());
    for arc in &draft.arcs {
        let what = || arc.id.map_or("this arc".into(), |id| format!("the arc `{}`", text(draft, id)));
        let mut end = |id: Id, at: At, verb: &str| match owners[id.0 as usize] {
            Some(owner) => beings[owner as usize].map(|being| nodes[being as usize]),
            None => {
                let message = format!("{} {verb} `{}`, which is no node of the net", what(), text(draft, id));
                report.add(Problem::error(at, message).hint("write the id of a place or transition"));
                None
            }
        };
        let source = end(arc.source, arc.source_at, "comes from");
        let target = end(arc.target, arc.target_at, "leads to");
        let joint = match (source, target) {
            (Some(Declared::Place(place)), Some(Declared::Transition(transition))) => (transition, place, true),
            (Some(Declared::Transition(transition)), Some(Declared::Place(place))) => (transition, place, false),
            (Some(Declared::Place(_)), Some(Declared::Place(_))) => {
                report.add(unfit(arc.at, &what(), "places"));
                continue;
            }
            (Some(Declared::Transition(_)), Some(Declared::Transition(_))) => {
                report.add(unfit(arc.at, &what(), "transitions"));
                continue;
            }
            // Reported already: an end that is not there, or a reference that leads nowhere.
            _ => continue,
        };
        let weight = arcs.entry(joint).or_insert(0);
        match weight.checked_add(arc.weight) {
            Some(sum) => *weight = sum,
            None => {
                let message =
                    format!("{} and those beside it have a weight of more than {} together", what(), u32::MAX);
                report.add(Problem::error(arc.at, message).hint("at most that is possible"));
            }
        }
    }
    arcs
}

fn unfit(at: At, what: &str, two: &str) -> Problem {
    Problem::error(at, format!("{what} joins two {two}")).hint("an arc joins a place and a transition")
}

/// The text of an id, for messages.
fn text(draft: &DraftNet<'_>, id: Id) -> String {
    shown(&draft.ids[id.0 as usize])
}
