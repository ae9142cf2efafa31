//! What is declared about a parameter.

use std::fmt;

use crate::ParameterType;

/// Values that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterDomain {
    Bool,
    /// Whole numbers, the bounds included.
    Integer {
        from: i64,
        to: i64,
    },
    /// Numbers, the bounds included.
    Double {
        from: f64,
        to: f64,
    },
    /// Any text.
    Text,
    /// One of these texts.
    OneOf(&'static [&'static str]),
}

impl ParameterDomain {
    /// Type of the values.
    pub fn kind(self) -> ParameterType {
        match self {
            ParameterDomain::Bool => ParameterType::Bool,
            ParameterDomain::Integer { .. } => ParameterType::Integer,
            ParameterDomain::Double { .. } => ParameterType::Double,
            ParameterDomain::Text | ParameterDomain::OneOf(_) => ParameterType::Text,
        }
    }
}

/// The values in words, after "is"; empty where the type says it all.
impl fmt::Display for ParameterDomain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterDomain::Bool | ParameterDomain::Text => Ok(()),
            ParameterDomain::Integer { from, to } => write!(f, "from {from} to {to}"),
            ParameterDomain::Double { from, to } => write!(f, "from {from:?} to {to:?}"),
            ParameterDomain::OneOf(words) => write!(f, "one of {}", words.join(", ")),
        }
    }
}

/// When a parameter may be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterChange {
    /// At the start, and by a request while the node runs.
    Live,
    /// At the start alone; the other place that sets it.
    AtStart(&'static str),
    /// Never as a parameter; the place that sets it.
    Elsewhere(&'static str),
}

/// Declaration of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declaration {
    /// Name, with dots between its parts.
    pub name: &'static str,
    /// Values that it may have.
    pub domain: ParameterDomain,
    pub change: ParameterChange,
    /// A sentence, with the unit.
    pub description: &'static str,
}

impl Declaration {
    /// Whether no request changes it.
    pub fn is_read_only(&self) -> bool {
        self.change != ParameterChange::Live
    }

    /// Further conditions for the descriptor, in a sentence: the words of a choice, and where a read-only one is set.
    pub fn constraints(&self) -> String {
        let words = match self.domain {
            ParameterDomain::OneOf(words) => format!("One of {}. ", words.join(", ")),
            ParameterDomain::Bool
            | ParameterDomain::Integer { .. }
            | ParameterDomain::Double { .. }
            | ParameterDomain::Text => String::new(),
        };
        let place = match self.change {
            ParameterChange::Live => String::new(),
            ParameterChange::AtStart(place) => format!("Set at the start: {place}."),
            ParameterChange::Elsewhere(place) => format!("Set by {place}."),
        };
        format!("{words}{place}").trim_end().to_owned()
    }
}
