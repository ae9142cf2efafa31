//! Names of nodes with wildcards.

use thiserror::Error;

/// Part of a name between slashes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum NameToken {
    Name(String),
    /// `*`: one part.
    One,
    /// `**`: any number of parts, also none.
    Any,
}

/// Absolute name of a node with wildcards: `*` stands for one part of a name, `**` for any number of parts. A name without a slash
/// at its start is one of the root namespace, as in rclcpp.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodePattern {
    tokens: Vec<NameToken>,
}

/// Text that is no name of a node.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum PatternError {
    /// Two slashes with nothing between them, or one at the end.
    #[error("a part of the name is empty")]
    EmptyPart,
    /// A wildcard in a part with other characters.
    #[error("'{0}': a wildcard stands for whole parts of a name; write * or ** between slashes")]
    PartOfPart(String),
    /// A part that no node has.
    #[error("'{0}' is no part of a node's name; these are letters, digits and '_', and begin with no digit")]
    Characters(String),
}

impl NodePattern {
    /// Reads a pattern.
    ///
    /// # Errors
    /// When it can be the name of no node.
    pub fn read(text: &str) -> Result<Self, PatternError> {
        let tokens = text.strip_prefix('/').unwrap_or(text).split('/').map(token).collect::<Result<_, _>>()?;
        Ok(NodePattern { tokens })
    }

    /// Whether it names one node, without a wildcard.
    pub fn is_exact(&self) -> bool {
        self.tokens.iter().all(|token| matches!(token, NameToken::Name(_)))
    }

    /// Whether it is a plain name in the root namespace.
    pub fn is_plain(&self) -> bool {
        self.tokens.len() == 1 && self.is_exact()
    }

    /// Whether the node with this absolute name is meant.
    pub fn matches(&self, node: &str) -> bool {
        // For each number of parts of the name: whether the tokens so far can stand for them.
        let parts: Vec<&str> = node.strip_prefix('/').unwrap_or(node).split('/').collect();
        let mut reached = vec![false; parts.len() + 1];
        reached[0] = true;
        for token in &self.tokens {
            match token {
                NameToken::Any => {
                    let first = reached.iter().position(|is_reached| *is_reached).unwrap_or(reached.len());
                    reached[first..].fill(true);
                }
                NameToken::One | NameToken::Name(_) => {
                    for at in (0..parts.len()).rev() {
                        let fits = if let NameToken::Name(name) = token { name == parts[at] } else { true };
                        reached[at + 1] = reached[at] && fits;
                    }
                    reached[0] = false;
                }
            }
        }
        reached[parts.len()]
    }
}

fn token(text: &str) -> Result<NameToken, PatternError> {
    let shown = || linewright_diagnostics::shown(text);
    match text {
        "" => Err(PatternError::EmptyPart),
        "*" => Ok(NameToken::One),
        "**" => Ok(NameToken::Any),
        _ if text.contains('*') => Err(PatternError::PartOfPart(shown())),
        _ if text.starts_with(|c: char| c.is_ascii_digit())
            || !text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') =>
        {
            Err(PatternError::Characters(shown()))
        }
        _ => Ok(NameToken::Name(text.to_owned())),
    }
}
