//! What is declared about a parameter.

use std::fmt;

use crate::ParameterType;

/// Values that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Domain {
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

impl Domain {
    /// Type of the values.
    pub fn kind(self) -> ParameterType {
        match self {
            Domain::Bool => ParameterType::Bool,
            Domain::Integer { .. } => ParameterType::Integer,
            Domain::Double { .. } => ParameterType::Double,
            Domain::Text | Domain::OneOf(_) => ParameterType::Text,
        }
    }
}

/// The values in words, after "is"; empty where the type says it all.
impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Domain::Bool | Domain::Text => Ok(()),
            Domain::Integer { from, to } => write!(f, "from {from} to {to}"),
            Domain::Double { from, to } => write!(f, "from {from:?} to {to:?}"),
            Domain::OneOf(words) => write!(f, "one of {}", words.join(", ")),
        }
    }
}

/// When a parameter may be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
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
    pub domain: Domain,
    pub change: Change,
    /// A sentence, with the unit.
    pub description: &'static str,
}

impl Declaration {
    /// Whether no request changes it.
    pub fn is_read_only(&self) -> bool {
        self.change != Change::Live
    }

    /// Further conditions for the descriptor, in a sentence: the words of a choice, and where a read-only one is set.
    pub fn constraints(&self) -> String {
        let words = match self.domain {
            Domain::OneOf(_) => format!("{}. ", capital(&self.domain.to_string())),
            Domain::Bool | Domain::Integer { .. } | Domain::Double { .. } | Domain::Text => String::new(),
        };
        let place = match self.change {
            Change::Live => String::new(),
            Change::AtStart(place) => format!("Set at the start: {place}."),
            Change::Elsewhere(place) => format!("Set by {place}."),
        };
        format!("{words}{place}").trim_end().to_owned()
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().chain(chars).collect())
}
