//! Conditions in the words of the seed's tables, for comparing a net with them.

use linewright_line::net::{Conjunction, Literal, StationTransition, TransitionKind, Var};
use linewright_line::{HandMode, Station};

/// The terms of one cell: `·` where the transition never fires, `N.C.` where there is no condition.
pub fn cell(terms: &[Conjunction], hand: HandMode) -> String {
    if terms.is_empty() {
        return "·".to_owned();
    }
    let words: Vec<String> = terms.iter().map(|term| term_words(term, hand)).collect();
    words.join(" or ")
}

fn term_words(term: &Conjunction, hand: HandMode) -> String {
    if term.is_empty() {
        return "N.C.".to_owned();
    }
    let words: Vec<String> = term.iter().map(|literal| literal_words(*literal, hand)).collect();
    words.join(" ")
}

fn literal_words(literal: Literal, hand: HandMode) -> String {
    let button = |button| match button {
        b if b == hand.forward() => "h_a",
        b if Some(b) == hand.back() => "h_b",
        b if Some(b) == hand.next() => "h_c",
        other => panic!("{other:?} is none of {hand:?}"),
    };
    let word = match literal.var {
        Var::Fault(..) => "f".to_owned(),
        Var::Arrived(..) => "s".to_owned(),
        Var::HoldLost => "lost".to_owned(),
        Var::Advance => "m_a".to_owned(),
        Var::AdvancePressed => "m_a↑".to_owned(),
        Var::Retract => "m_r".to_owned(),
        Var::RetractPressed => "m_r↑".to_owned(),
        Var::Held(b) => button(b).to_owned(),
        Var::Pressed(b) => format!("{}↑", button(b)),
        Var::Causal(_) => "IVC".to_owned(),
        Var::WayHome(_) => "IVC-home".to_owned(),
        Var::OnPath(_) | Var::OnAnyPath => "path".to_owned(),
        Var::NeighbourSettled(_) => "settled".to_owned(),
        Var::MasterStop => "stop".to_owned(),
        Var::Ordered(_) => "ordered".to_owned(),
        Var::Secure => "secure".to_owned(),
    };
    if literal.on { word } else { format!("¬{word}") }
}

/// The seed's number of a transition of the operation `op`, or of its step; `None` for another's.
pub fn number(station: &Station, transition: &StationTransition, op: linewright_line::OpId) -> Option<&'static str> {
    use linewright_line::net::Block::{Normal, Recovery};
    let step = station.step_of(op);
    let reversible =
        matches!(station.operations[op.index()].module, linewright_line::OperationModule::Reversible { .. });
    Some(match transition.kind {
        TransitionKind::Stop(o, Normal) if o == op => "t1",
        TransitionKind::Resume(o, Normal) if o == op => "t2",
        TransitionKind::Complete(o, Normal) if o == op => "t3",
        TransitionKind::Undo(o) if o == op => "t4",
        TransitionKind::Retract(o) | TransitionKind::EnterPath(o) if o == op => "t5",
        TransitionKind::Stop(o, Recovery) if o == op => "t6",
        TransitionKind::Resume(o, Recovery) if o == op => "t7",
        TransitionKind::Complete(o, Recovery) if o == op => "t8",
        TransitionKind::Restart(o) if o == op => "t9",
        TransitionKind::Again(o) if o == op => "t10",
        TransitionKind::Next { from, .. } if from == step && reversible => "t11",
        TransitionKind::Next { from, .. } if from == step => "t4",
        TransitionKind::Back { from, .. } if from == step => "t12",
        _ => return None,
    })
}
