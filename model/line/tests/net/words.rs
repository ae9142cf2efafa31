//! Conditions in the words of the seed's tables, for comparing a net with them.

use linewright_line::net::{Kind, Literal, Term, Transition, Var};
use linewright_line::{Hand, Station};

/// The terms of one cell: `·` where the transition never fires, `N.C.` where nothing is asked.
pub fn cell(terms: &[Term], hand: Hand) -> String {
    if terms.is_empty() {
        return "·".to_owned();
    }
    let words: Vec<String> = terms.iter().map(|term| term_words(term, hand)).collect();
    words.join(" or ")
}

fn term_words(term: &Term, hand: Hand) -> String {
    if term.is_empty() {
        return "N.C.".to_owned();
    }
    let words: Vec<String> = term.iter().map(|literal| literal_words(*literal, hand)).collect();
    words.join(" ")
}

fn literal_words(literal: Literal, hand: Hand) -> String {
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
pub fn number(station: &Station, transition: &Transition, op: linewright_line::OpId) -> Option<&'static str> {
    use linewright_line::net::Block::{Normal, Recovery};
    let step = station.step_of(op);
    let reversible = matches!(station.operations[op.index()].module, linewright_line::Module::Reversible { .. });
    Some(match transition.kind {
        Kind::Stop(o, Normal) if o == op => "t1",
        Kind::Resume(o, Normal) if o == op => "t2",
        Kind::Complete(o, Normal) if o == op => "t3",
        Kind::Undo(o) if o == op => "t4",
        Kind::Retract(o) | Kind::EnterPath(o) if o == op => "t5",
        Kind::Stop(o, Recovery) if o == op => "t6",
        Kind::Resume(o, Recovery) if o == op => "t7",
        Kind::Complete(o, Recovery) if o == op => "t8",
        Kind::Restart(o) if o == op => "t9",
        Kind::Again(o) if o == op => "t10",
        Kind::Next { from, .. } if from == step && reversible => "t11",
        Kind::Next { from, .. } if from == step => "t4",
        Kind::Back { from, .. } if from == step => "t12",
        _ => return None,
    })
}
