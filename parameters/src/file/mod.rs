//! Parameter files of ROS 2.
//!
//! ```yaml
//! /**:                      # for every node
//!   ros__parameters:
//!     log_level: warn
//! /hall/drill:              # for this one, and for /hall/mill below
//!   ros__parameters:
//!     report: {period_s: 2.5}      # report.period_s
//! /hall:
//!   mill:
//!     ros__parameters:
//!       report.period_s: 2.5
//! ```

pub(crate) mod yaml;

use std::ops::Range;

use linewright_diagnostics::{Problem, Problems, Report, shown};

use crate::scalar::value;
use crate::{NodePattern, ParameterValue};
use yaml::{YamlKind, YamlNode, document};

/// Most bytes of a file.
pub const FILE_BYTES_MAX: usize = 1 << 20;

/// Most values in a file.
const ENTRIES_MAX: usize = 5_000;

/// Key below which the parameters of a node stand.
const PARAMETERS: &str = "ros__parameters";

/// A value in a file, for the nodes of its section.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FileEntry {
    pub nodes: NodePattern,
    /// Name of the parameter, with dots.
    pub name: String,
    pub value: ParameterValue,
    /// Place of the last part of the name.
    pub name_at: Range<usize>,
    pub value_at: Range<usize>,
}

/// A parameter file that has been read.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterFile {
    pub(crate) name: String,
    pub(crate) text: String,
    /// In the order of the file.
    pub(crate) entries: Vec<FileEntry>,
}

impl ParameterFile {
    /// The text that was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Reads the text of a file; `name` is for messages.
    ///
    /// # Errors
    /// All that is wrong with its form: names of nodes, sections without parameters, names that occur twice. Which parameters there
    /// are is looked at by [`apply`](crate::apply).
    pub fn read(name: &str, text: &str) -> Result<Self, Problems> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut report = Report::default();
        let mut entries = Vec::new();
        match document(text) {
            Ok(Some(YamlNode { kind: YamlKind::Map(sections), .. })) => {
                read_sections(&sections, "", &mut entries, &mut report);
            }
            Ok(None) => {}
            Ok(Some(other)) => report.add(
                Problem::error(other.span, "a parameter file is a map of nodes' names")
                    .hint(format!("begin with a node, as `/**:`, and `{PARAMETERS}:` below it")),
            ),
            Err(problem) => report.add(*problem),
        }
        let read = if report.has_errors() { None } else { Some(entries) };
        let (entries, _) = report.close(read, name, text)?;
        Ok(ParameterFile { name: name.to_owned(), text: text.to_owned(), entries })
    }
}

/// Reads the sections below a part of a node's name.
fn read_sections(
    sections: &[(String, Range<usize>, YamlNode)],
    above: &str,
    entries: &mut Vec<FileEntry>,
    report: &mut Report,
) {
    for (key, key_at, node) in sections {
        if key == PARAMETERS {
            match NodePattern::read(above) {
                _ if above.is_empty() => report.add(
                    Problem::error(key_at.clone(), format!("{PARAMETERS} stands below no node"))
                        .hint("put it below a node's name, as `/**:` for every node"),
                ),
                Ok(nodes) => read_parameters(&nodes, node, "", key_at, entries, report),
                Err(error) => report.add(Problem::error(key_at.clone(), format!("node '{}': {error}", shown(above)))),
            }
            continue;
        }
        let name = if above.is_empty() { key.clone() } else { format!("{above}/{}", key.trim_start_matches('/')) };
        match &node.kind {
            YamlKind::Map(below) => read_sections(below, &name, entries, report),
            _ => report.add(
                Problem::error(key_at.clone(), format!("node '{}' has no {PARAMETERS}", shown(&name)))
                    .hint(format!("put the parameters of a node below `{PARAMETERS}:`")),
            ),
        }
    }
}

/// Reads the parameters below a part of their names.
fn read_parameters(
    nodes: &NodePattern,
    node: &YamlNode,
    above: &str,
    key_at: &Range<usize>,
    entries: &mut Vec<FileEntry>,
    report: &mut Report,
) {
    match &node.kind {
        YamlKind::Map(below) => {
            for (key, key_at, node) in below {
                let name = if above.is_empty() { key.clone() } else { format!("{above}.{key}") };
                read_parameters(nodes, node, &name, key_at, entries, report);
            }
        }
        // A section without parameters.
        YamlKind::Plain(text) if above.is_empty() && text.is_empty() => {}
        _ if above.is_empty() => {
            report.add(Problem::error(key_at.clone(), format!("{PARAMETERS} is no map of parameters' names")));
        }
        _ if entries.len() == ENTRIES_MAX => {
            let text = format!("more than {ENTRIES_MAX} values in one file");
            if !report.has_errors() {
                report.add(Problem::error(key_at.clone(), text));
            }
        }
        YamlKind::Plain(_) | YamlKind::Quoted(_) | YamlKind::List(_) => {
            let same = |entry: &&FileEntry| entry.nodes == *nodes && entry.name == above;
            if let Some(earlier) = entries.iter().find(same) {
                let text = format!("{} is set twice for the same nodes", shown(above));
                report.add(Problem::error(key_at.clone(), text).earlier(earlier.name_at.clone()));
                return;
            }
            let (value, value_at) = (value(node), node.span.clone());
            let (nodes, name, name_at) = (nodes.clone(), above.to_owned(), key_at.clone());
            entries.push(FileEntry { nodes, name, value, name_at, value_at });
        }
    }
}
