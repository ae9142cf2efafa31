//! Topic names: what is allowed, what they expand to, and what a remap makes of them.
//!
//! A name is absolute (`/line/mode`), relative to the node's namespace (`mode`) or private to the
//! node (`~/state`). Remap rules are compared with the *expanded* name, and their right side is
//! expanded too, as rcl does it. The client library expands nothing itself and drops a slash for
//! relative names in the root namespace, so it is only ever given absolute names.

use thiserror::Error;

/// A name that ROS 2 does not allow.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NameError {
    /// Nothing there.
    #[error("a name must not be empty")]
    Empty,
    /// A character outside letters, digits, `_`, `/` and a leading `~/`.
    #[error("'{name}' contains {bad:?}; allowed are letters, digits, '_' and '/'")]
    Character {
        name: String,
        /// The first offender.
        bad: char,
    },
    /// A part that is empty, starts with a digit or holds `__`.
    #[error("'{name}' has a part '{part}'; parts are not empty, start with no digit and hold no '__'")]
    Part {
        name: String,
        /// The offending part.
        part: String,
    },
    /// `~` anywhere but as `~/…` at the start.
    #[error("'{name}': '~' stands only at the start, followed by '/'")]
    Tilde { name: String },
}

/// Expands a topic name for the node `namespace`/`node` and checks it.
pub fn expand(name: &str, namespace: &str, node: &str) -> Result<String, NameError> {
    let root = if namespace == "/" { "" } else { namespace };
    let full = if name.is_empty() {
        return Err(NameError::Empty);
    } else if name.starts_with('/') {
        name.to_owned()
    } else if let Some(private) = name.strip_prefix('~') {
        let Some(rest) = private.strip_prefix('/') else { return Err(NameError::Tilde { name: name.to_owned() }) };
        format!("{root}/{node}/{rest}")
    } else {
        format!("{root}/{name}")
    };
    check_absolute(&full)?;
    Ok(full)
}

/// Checks a namespace: `/` or an absolute name. A missing leading slash is added, as rcl does.
pub fn namespace(text: &str) -> Result<String, NameError> {
    let full = if text.starts_with('/') { text.to_owned() } else { format!("/{text}") };
    if full != "/" {
        check_absolute(&full)?;
    }
    Ok(full)
}

/// Checks a node's base name: one part, no slash.
pub fn node_name(text: &str) -> Result<String, NameError> {
    if text.is_empty() {
        return Err(NameError::Empty);
    }
    if text.contains('/') {
        return Err(NameError::Character { name: text.to_owned(), bad: '/' });
    }
    check_absolute(&format!("/{text}"))?;
    Ok(text.to_owned())
}

fn check_absolute(full: &str) -> Result<(), NameError> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '/';
    if let Some(bad) = full.chars().find(|c| !allowed(*c)) {
        return Err(match bad {
            '~' => NameError::Tilde { name: full.to_owned() },
            bad => NameError::Character { name: full.to_owned(), bad },
        });
    }
    for part in full.split('/').skip(1) {
        if part.is_empty() || part.starts_with(|c: char| c.is_ascii_digit()) || part.contains("__") {
            return Err(NameError::Part { name: full.to_owned(), part: part.to_owned() });
        }
    }
    Ok(())
}

/// Target of a remap rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RemapTarget {
    /// The node's name (`__node`, `__name`).
    NodeName,
    /// The node's namespace (`__ns`).
    Namespace,
    /// A topic, by this name.
    Topic(String),
}

/// One `[node:]from:=to`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remap {
    /// The rule is for nodes of this name only.
    pub node: Option<String>,
    /// Target.
    pub target: RemapTarget,
    /// Replacement.
    pub to: String,
}

/// The name and namespace a node ends up with. The first matching rule wins; the name is decided
/// first, and namespace rules for one node are matched against its new name, as in rcl.
pub fn identify(rules: &[Remap], namespace_given: &str, name_given: &str) -> Result<(String, String), NameError> {
    let first = |target: RemapTarget, name: &str| {
        rules.iter().find(|r| r.target == target && r.node.as_deref().is_none_or(|n| n == name)).map(|r| r.to.clone())
    };
    let name = node_name(&first(RemapTarget::NodeName, name_given).unwrap_or_else(|| name_given.to_owned()))?;
    let space = namespace(&first(RemapTarget::Namespace, &name).unwrap_or_else(|| namespace_given.to_owned()))?;
    Ok((space, name))
}

/// The absolute topic name after expansion and the first matching rule.
pub fn resolve(rules: &[Remap], topic: &str, namespace: &str, node: &str) -> Result<String, NameError> {
    let full = expand(topic, namespace, node)?;
    for rule in rules.iter().filter(|r| r.node.as_deref().is_none_or(|n| n == node)) {
        if let RemapTarget::Topic(from) = &rule.target
            && expand(from, namespace, node)? == full
        {
            return expand(&rule.to, namespace, node);
        }
    }
    Ok(full)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expansion() {
        for (name, expected) in [
            ("/a/b", "/a/b"),
            ("state", "/line/state"),
            ("s1/state", "/line/s1/state"),
            ("~/state", "/line/station/state"),
        ] {
            assert_eq!(expand(name, "/line", "station").unwrap(), expected);
        }
        assert_eq!(expand("state", "/", "n").unwrap(), "/state");
        assert_eq!(expand("~/state", "/", "n").unwrap(), "/n/state");
    }

    #[test]
    fn refused_names_say_why() {
        for (name, what) in [
            ("", "empty"),
            ("a b", "' '"),
            ("a//b", "part"),
            ("a/", "part"),
            ("/", "part"),
            ("1a", "part"),
            ("a__b", "part"),
            ("~state", "~"),
            ("a/~/b", "~"),
            ("schöner", "'ö'"),
            ("{ns}/a", "'{'"),
        ] {
            let error = expand(name, "/line", "n").unwrap_err().to_string();
            assert!(error.contains(what), "{name}: {error}");
        }
        assert!(node_name("a/b").is_err());
        assert_eq!(namespace("line").unwrap(), "/line");
        assert_eq!(namespace("/").unwrap(), "/");
        assert!(namespace("/line/").is_err());
    }

    fn rule(node: Option<&str>, target: RemapTarget, to: &str) -> Remap {
        Remap { node: node.map(str::to_owned), target, to: to.to_owned() }
    }

    #[test]
    fn the_first_matching_rule_wins() {
        let topic = |from: &str| RemapTarget::Topic(from.to_owned());
        let rules = [
            rule(Some("other"), topic("mode"), "/wrong"),
            rule(None, topic("/line/mode"), "order"),
            rule(None, topic("mode"), "/late"),
            rule(None, topic("~/state"), "~/status"),
        ];
        assert_eq!(resolve(&rules, "mode", "/line", "s1").unwrap(), "/line/order");
        assert_eq!(resolve(&rules, "mode", "/line", "other").unwrap(), "/wrong");
        assert_eq!(resolve(&rules, "~/state", "/line", "s1").unwrap(), "/line/s1/status");
        assert_eq!(resolve(&rules, "/mode", "/line", "s1").unwrap(), "/mode");
    }

    #[test]
    fn a_namespace_rule_for_one_node_matches_the_new_name() {
        let rules = [
            rule(Some("a"), RemapTarget::NodeName, "b"),
            rule(Some("a"), RemapTarget::Namespace, "/old"),
            rule(Some("b"), RemapTarget::Namespace, "new"),
        ];
        assert_eq!(identify(&rules, "/line", "a").unwrap(), ("/new".to_owned(), "b".to_owned()));
        assert_eq!(identify(&rules, "/line", "c").unwrap(), ("/line".to_owned(), "c".to_owned()));
    }
}
