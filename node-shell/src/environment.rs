//! The ROS 2 environment variables that select the communication partners.
//!
//! The client library reads none of them, so a node would answer in domain 0 on every interface whatever its user
//! exported. A value that cannot be honoured is an error, not a guess: a line in the wrong domain moves at the wrong
//! operator's command.

use thiserror::Error;

/// Highest domain id whose UDP ports exist (RTPS port formula, 16-bit ports).
pub const DOMAIN_ID_MAX: u16 = 232;

/// Discovery range of participants (`ROS_AUTOMATIC_DISCOVERY_RANGE`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// All participants that multicast reaches.
    Subnet,
    /// This machine only.
    Localhost,
    /// No other participant.
    Off,
}

/// Settings from the environment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Environment {
    /// `ROS_DOMAIN_ID`, 0 when unset.
    pub domain_id: u16,
    /// The range, if the environment names one.
    pub range: Option<Range>,
    /// Settings that are understood but not supported, for the log.
    pub warnings: Vec<String>,
}

/// An environment variable that cannot be honoured.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum EnvironmentError {
    /// Not a number from 0 to 232.
    #[error("ROS_DOMAIN_ID is '{value}', expected a number from 0 to {DOMAIN_ID_MAX}")]
    DomainId {
        /// Value found in the environment.
        value: String,
    },
    /// Not one of the four ranges.
    #[error("ROS_AUTOMATIC_DISCOVERY_RANGE is '{value}', expected SUBNET, LOCALHOST, OFF or SYSTEM_DEFAULT")]
    DiscoveryRange {
        /// Value found in the environment.
        value: String,
    },
    /// Neither 0 nor 1.
    #[error("ROS_LOCALHOST_ONLY is '{value}', expected 0 or 1")]
    LocalhostOnly {
        /// Value found in the environment.
        value: String,
    },
}

/// Reads the variables through `var`. An empty variable counts as unset, as in ROS 2.
pub fn read(var: impl Fn(&str) -> Option<String>) -> Result<Environment, EnvironmentError> {
    let set = |name: &str| var(name).filter(|value| !value.is_empty());
    let domain_id = match set("ROS_DOMAIN_ID") {
        None => 0,
        Some(value) => match value.parse::<u16>() {
            Ok(id) if id <= DOMAIN_ID_MAX => id,
            _ => return Err(EnvironmentError::DomainId { value }),
        },
    };
    let mut warnings = Vec::new();
    if let Some(peers) = set("ROS_STATIC_PEERS") {
        warnings.push(format!("ROS_STATIC_PEERS='{peers}' is not supported and has no effect"));
    }
    // The older switch wins over the range when it is on, as in rcl.
    let range = match set("ROS_LOCALHOST_ONLY").as_deref() {
        Some("1") => Some(Range::Localhost),
        None | Some("0") => range(set("ROS_AUTOMATIC_DISCOVERY_RANGE"))?,
        Some(other) => return Err(EnvironmentError::LocalhostOnly { value: other.to_owned() }),
    };
    Ok(Environment { domain_id, range, warnings })
}

fn range(value: Option<String>) -> Result<Option<Range>, EnvironmentError> {
    let Some(value) = value else { return Ok(None) };
    match value.as_str() {
        "SUBNET" => Ok(Some(Range::Subnet)),
        "LOCALHOST" => Ok(Some(Range::Localhost)),
        "OFF" => Ok(Some(Range::Off)),
        // "Let the middleware decide": ours reaches for the subnet.
        "SYSTEM_DEFAULT" => Ok(Some(Range::Subnet)),
        _ => Err(EnvironmentError::DiscoveryRange { value }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn env<'a>(pairs: &'a [(&'a str, &'a str)]) -> impl Fn(&str) -> Option<String> + 'a {
        move |name| pairs.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned())
    }

    #[test]
    fn domain_ids() {
        for (text, expected) in [("0", Some(0)), ("42", Some(42)), ("232", Some(232)), ("", Some(0))] {
            assert_eq!(read(env(&[("ROS_DOMAIN_ID", text)])).ok().map(|e| e.domain_id), expected, "{text}");
        }
        for text in ["233", "-1", "70000", "one", " 1", "1 "] {
            let error = read(env(&[("ROS_DOMAIN_ID", text)])).unwrap_err();
            assert!(error.to_string().contains(text), "{error}");
        }
        assert_eq!(read(env(&[])).unwrap(), Environment { domain_id: 0, range: None, warnings: vec![] });
    }

    #[test]
    fn ranges() {
        type Case<'a> = (&'a [(&'a str, &'a str)], Option<Range>);
        let cases: &[Case<'_>] = &[
            (&[], None),
            (&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")], Some(Range::Subnet)),
            (&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")], Some(Range::Localhost)),
            (&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")], Some(Range::Off)),
            (&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SYSTEM_DEFAULT")], Some(Range::Subnet)),
            (&[("ROS_LOCALHOST_ONLY", "1"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")], Some(Range::Localhost)),
            (&[("ROS_LOCALHOST_ONLY", "0"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")], Some(Range::Subnet)),
            (&[("ROS_LOCALHOST_ONLY", "0")], None),
        ];
        for (pairs, expected) in cases {
            assert_eq!(read(env(pairs)).unwrap().range, *expected, "{pairs:?}");
        }
        for (name, value) in [("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost"), ("ROS_LOCALHOST_ONLY", "yes")] {
            let error = read(env(&[(name, value)])).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains(value), "{error}");
        }
    }

    #[test]
    fn static_peers_are_reported_not_obeyed() {
        let environment = read(env(&[("ROS_STATIC_PEERS", "10.0.0.7")])).unwrap();
        assert_eq!(environment.warnings.len(), 1);
        assert!(environment.warnings[0].contains("10.0.0.7"));
    }
}
