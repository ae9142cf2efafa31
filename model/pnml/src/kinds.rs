//! Elements that change the meaning of a net, and their recognition.
//!
//! Unknown elements are passed over, as the standard requires: most of them are drawings and remarks. But a net with an
//! inhibitor arc that is taken for an ordinary one is another net, and whatever is then proved is proved of that. So what
//! tools are known to write for nets that are more than place/transition nets is listed here, and refused.

/// Whether a net of this type is a place/transition net: the URI of the standard, those of its predecessors
/// (`…/ptNetb`), and what PIPE, WoPeD and others write (`P/T net`). The core model has no labels, and is one as well.
pub(crate) fn is_place_transition(net_type: &str) -> bool {
    let word: String = net_type.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect();
    word.is_empty() || word.ends_with("ptnet") || word.ends_with("ptnetb") || word.ends_with("pnmlcoremodel")
}

/// Whether an arc of this type moves tokens and does nothing else.
pub(crate) fn is_ordinary_arc(arc_type: &str) -> bool {
    matches!(arc_type.to_ascii_lowercase().as_str(), "" | "normal" | "ordinary" | "standard" | "pt" | "ptnet")
}

/// Labels of coloured nets: with `hlinitialMarking` in a place, for example, the kind of the net is certain.
pub(crate) fn is_coloured_label(element: &str) -> bool {
    matches!(element, "hlinitialMarking" | "hlinscription" | "condition" | "declaration")
}
