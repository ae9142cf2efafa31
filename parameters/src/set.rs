//! The parameters of one node, with their values.

use thiserror::Error;

use crate::{Declaration, ParameterChange, ParameterDomain, ParameterType, ParameterValue};

/// Reason why a parameter is not set.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Refusal {
    /// The node has no such parameter.
    #[error("{name} is no parameter of this node{}", hint.as_ref().map(|hint| format!("; {hint}")).unwrap_or_default())]
    Unknown {
        name: String,
        /// A name that is near.
        hint: Option<String>,
    },
    /// A value of another type.
    #[error("{name} is {}, and not {}{}", expected.phrase(), found.kind().phrase(), advice(*expected, found))]
    WrongType { name: &'static str, expected: ParameterType, found: ParameterValue },
    /// A value beyond the bounds, or none of the choices.
    #[error("{name} is {domain}, and not {found}")]
    OutOfDomain { name: &'static str, domain: ParameterDomain, found: ParameterValue },
    /// It does not change while the node runs.
    #[error("{name} is read-only while the node runs, and is {is}; it is set at the start: {place}")]
    AtStart {
        name: &'static str,
        is: ParameterValue,
        /// Place that sets it.
        place: &'static str,
    },
    /// It follows from something else.
    #[error("{name} is read-only, and is {is}; it is set by {place}")]
    Elsewhere {
        name: &'static str,
        is: ParameterValue,
        /// Place that sets it.
        place: &'static str,
    },
}

/// How to write a whole number where a double is expected; empty otherwise.
fn advice(expected: ParameterType, found: &ParameterValue) -> String {
    match (expected, found) {
        (ParameterType::Double, ParameterValue::Integer(whole)) => format!("; write {whole}.0"),
        _ => String::new(),
    }
}

/// When a value is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    Start,
    Running,
}

#[derive(Clone, Debug, PartialEq)]
struct DeclaredParameter {
    declaration: &'static Declaration,
    value: ParameterValue,
}

/// The declared parameters of a node, by name. None is added or removed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterSet {
    parameters: Vec<DeclaredParameter>,
}

impl ParameterSet {
    /// These parameters with their first values, which are taken as they are. Of two with one name the last counts.
    pub fn new(declared: impl IntoIterator<Item = (&'static Declaration, ParameterValue)>) -> Self {
        let mut set = ParameterSet::default();
        for (declaration, value) in declared {
            let parameter = DeclaredParameter { declaration, value };
            match set.position(declaration.name) {
                Ok(at) => set.parameters[at] = parameter,
                Err(at) => set.parameters.insert(at, parameter),
            }
        }
        set
    }

    fn position(&self, name: &str) -> Result<usize, usize> {
        self.parameters.binary_search_by(|parameter| parameter.declaration.name.cmp(name))
    }

    fn find(&self, name: &str) -> Option<&DeclaredParameter> {
        self.position(name).ok().map(|at| &self.parameters[at])
    }

    /// All of them, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Declaration, &ParameterValue)> {
        self.parameters.iter().map(|parameter| (parameter.declaration, &parameter.value))
    }

    /// The declaration of a parameter, if there is one of this name.
    pub fn declaration(&self, name: &str) -> Option<&'static Declaration> {
        self.find(name).map(|parameter| parameter.declaration)
    }

    /// The value of a parameter, if there is one of this name.
    pub fn get(&self, name: &str) -> Option<&ParameterValue> {
        self.find(name).map(|parameter| &parameter.value)
    }

    /// The text that a parameter holds, if it holds one.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.get(name) {
            Some(ParameterValue::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// The floating point number that a parameter holds, if it holds one.
    pub fn double(&self, name: &str) -> Option<f64> {
        match self.get(name) {
            Some(ParameterValue::Double(value)) => Some(*value),
            _ => None,
        }
    }

    /// Names below these beginnings, or all if there are none, with at most `depth` parts behind the beginning (0 for any number); and
    /// what stands before their last dots, each once. As in rclcpp.
    pub fn list(&self, prefixes: &[String], depth: u64) -> (Vec<&'static str>, Vec<&'static str>) {
        let is_near = |rest: &str| depth == 0 || (rest.matches('.').count() as u64) < depth;
        let is_below = |name: &str, prefix: &str| match name.strip_prefix(prefix) {
            Some("") => true,
            Some(rest) => rest.starts_with('.') && is_near(rest),
            None => false,
        };
        let is_listed = |name: &str| match prefixes {
            [] => is_near(name),
            prefixes => prefixes.iter().any(|prefix| is_below(name, prefix)),
        };
        let names: Vec<_> = self.iter().map(|(declared, _)| declared.name).filter(|name| is_listed(name)).collect();
        let mut before: Vec<&str> = Vec::new();
        for (prefix, _) in names.iter().filter_map(|name| name.rsplit_once('.')) {
            if !before.contains(&prefix) {
                before.push(prefix);
            }
        }
        (names, before)
    }

    /// Sets a parameter while the node runs. True if its value is another one now; a value that it has already is taken, also
    /// of a read-only one, so that what was dumped can be loaded.
    ///
    /// # Errors
    /// When there is no such parameter, it is read-only, or the value is not of its type and domain. Nothing has changed then.
    pub fn set(&mut self, name: &str, value: &ParameterValue) -> Result<bool, Refusal> {
        self.put(name, value, Moment::Running)
    }

    /// Sets several while the node runs, all or none; the names of those that have another value now, each once.
    ///
    /// # Errors
    /// As [`ParameterSet::set`], for the first that is refused. Nothing has changed then.
    pub fn set_all<'v>(
        &mut self,
        values: impl IntoIterator<Item = (&'v str, &'v ParameterValue)>,
    ) -> Result<Vec<&'static str>, Refusal> {
        let mut next = self.clone();
        for (name, value) in values {
            next.set(name, value)?;
        }
        let both = self.parameters.iter().zip(&next.parameters);
        let changed = both.filter(|(old, new)| old.value != new.value);
        let changed = changed.map(|(_, new)| new.declaration.name).collect();
        *self = next;
        Ok(changed)
    }

    /// Sets a parameter before the node runs.
    pub(crate) fn start_with(&mut self, name: &str, value: &ParameterValue) -> Result<bool, Refusal> {
        self.put(name, value, Moment::Start)
    }

    fn put(&mut self, name: &str, value: &ParameterValue, moment: Moment) -> Result<bool, Refusal> {
        let Ok(at) = self.position(name) else { return Err(self.unknown(name)) };
        let DeclaredParameter { declaration, value: is } = &mut self.parameters[at];
        let Declaration { name, domain, change, .. } = **declaration;
        if is == value {
            return Ok(false);
        }
        if value.kind() != domain.kind() {
            return Err(Refusal::WrongType { name, expected: domain.kind(), found: value.clone() });
        }
        match (change, moment) {
            (ParameterChange::Live, _) | (ParameterChange::AtStart(_), Moment::Start) => {}
            (ParameterChange::AtStart(place), Moment::Running) => {
                return Err(Refusal::AtStart { name, is: is.clone(), place });
            }
            (ParameterChange::Elsewhere(place), _) => return Err(Refusal::Elsewhere { name, is: is.clone(), place }),
        }
        let is_in = match (domain, value) {
            (ParameterDomain::Integer { from, to }, ParameterValue::Integer(value)) => (from..=to).contains(value),
            // What is no number is within no bounds.
            (ParameterDomain::Double { from, to }, ParameterValue::Double(value)) => (from..=to).contains(value),
            (ParameterDomain::OneOf(words), ParameterValue::Text(value)) => words.contains(&value.as_str()),
            _ => true,
        };
        if !is_in {
            return Err(Refusal::OutOfDomain { name, domain, found: value.clone() });
        }
        *is = value.clone();
        Ok(true)
    }

    fn unknown(&self, name: &str) -> Refusal {
        let hint = linewright_text::nearest(name, self.iter().map(|(declared, _)| declared.name));
        let hint = hint.map(|near| format!("did you mean {near}?"));
        Refusal::Unknown { name: linewright_diagnostics::shown(name), hint }
    }
}
