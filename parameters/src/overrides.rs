//! Values from files and arguments, put into the parameters of a node before it runs.

use linewright_diagnostics::{Problem, Problems, Report, shown};
use thiserror::Error;

use crate::{ParameterFile, ParameterSet, ParameterValue, Refusal};

/// One `[node:]name:=value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// For nodes of this name only, in whichever namespace.
    pub node: Option<String>,
    /// Name of the parameter, with dots.
    pub name: String,
    pub value: ParameterValue,
}

/// File or argument that sets parameters before a node runs.
#[derive(Clone, Debug, PartialEq)]
pub enum Override {
    File(ParameterFile),
    Argument(Argument),
}

impl From<ParameterFile> for Override {
    fn from(file: ParameterFile) -> Self {
        Override::File(file)
    }
}

impl From<Argument> for Override {
    fn from(argument: Argument) -> Self {
        Override::Argument(argument)
    }
}

/// Values that a node does not take.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum OverrideError {
    /// In a file.
    #[error("{0:#}")]
    File(Box<Problems>),
    /// In an argument.
    #[error("'-p {}{}:={}': {refusal}", node.as_ref().map(|node| format!("{node}:")).unwrap_or_default(), shown(name), value)]
    Argument { node: Option<String>, name: String, value: ParameterValue, refusal: Box<Refusal> },
}

/// Puts the values for the node with this absolute name into its parameters: in the order given, so that the last one counts.
/// A value for exactly this node must be for one of its parameters; a value for several nodes may also be for a parameter of
/// other nodes: `known` has the names of all. Returns warnings.
///
/// # Errors
/// When a value is not taken: unknown, of another type, out of bounds, or set elsewhere. All such places of the first file that has
/// one.
pub fn apply(
    set: &mut ParameterSet,
    overrides: &[Override],
    node: &str,
    known: &[&str],
) -> Result<Vec<String>, OverrideError> {
    let mut warnings = Vec::new();
    let base = node.rsplit('/').next().unwrap_or(node);
    for given in overrides {
        match given {
            Override::File(file) => warnings.extend(apply_file(set, file, (node, base), known)?),
            Override::Argument(Argument { node: only, name, value }) => {
                if only.as_ref().is_some_and(|only| only != base) {
                    continue;
                }
                match set.start_with(name, value) {
                    Ok(_) => {}
                    Err(Refusal::Unknown { .. }) if only.is_none() && known.contains(&name.as_str()) => {}
                    Err(refusal) => {
                        let (node, name, value) = (only.clone(), name.clone(), value.clone());
                        return Err(OverrideError::Argument { node, name, value, refusal: Box::new(refusal) });
                    }
                }
            }
        }
    }
    Ok(warnings)
}

fn apply_file(
    set: &mut ParameterSet,
    file: &ParameterFile,
    (node, base): (&str, &str),
    known: &[&str],
) -> Result<Option<String>, OverrideError> {
    let mut report = Report::default();
    let mut warning = None;
    for entry in &file.entries {
        if !entry.nodes.matches(node) {
            if entry.nodes.is_plain() && entry.nodes.matches(&format!("/{base}")) {
                let name = &file.name;
                warning = Some(format!(
                    "{name}: '{base}' without a namespace is the node /{base}, and not this one: write {node}, or /**/{base}"
                ));
            }
            continue;
        }
        let refusal = match set.start_with(&entry.name, &entry.value) {
            Ok(_) => continue,
            Err(Refusal::Unknown { .. }) if !entry.nodes.is_exact() && known.contains(&entry.name.as_str()) => continue,
            Err(refusal) => refusal,
        };
        let (at, hint) = match &refusal {
            Refusal::Unknown { .. } => (&entry.name_at, None),
            Refusal::WrongType { .. } | Refusal::OutOfDomain { .. } => (&entry.value_at, None),
            Refusal::AtStart { .. } | Refusal::Elsewhere { .. } => (&entry.value_at, Some("take it out here")),
        };
        report.add(Problem::error(at.clone(), refusal.to_string()).maybe_hint(hint.map(str::to_owned)));
    }
    if report.has_errors() {
        return Err(OverrideError::File(Box::new(report.into_problems(&file.name, &file.text))));
    }
    Ok(warning)
}
