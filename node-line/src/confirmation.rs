//! An operator's confirmation of where a station stands, as the text of its message.
//!
//! The first line is the place: empty for where its switches measure it, an operation, or `rest: ` and a rest. Each further line is
//! a parameter of the task that it stands in, `slot=2`. A station of before there were any takes the text for an operation that it does
//! not have, and refuses it.

use std::sync::Arc;

use linewright_line::{PARAMETERS_MAX, REJOIN_AT_REST, Station};
use linewright_station_logic::RejoinAt;
use thiserror::Error;

use crate::foreign::quoted;

/// Where a station stands, with the parameters of its task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confirmation {
    pub at: RejoinAt,
    pub numbers: Vec<(Arc<str>, i32)>,
}

/// Reason why a text is no confirmation.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ConfirmationError {
    #[error("unknown rest '{name}'; rests: {known}")]
    UnknownRest { name: String, known: String },
    #[error("unknown operation '{name}'; operations: {known}")]
    UnknownOperation { name: String, known: String },
    #[error("'{text}' is not NAME=NUMBER, e.g. slot=2")]
    NotANumber { text: String },
    #[error("more than {PARAMETERS_MAX} numbers")]
    TooMany,
}

impl Confirmation {
    /// Reads a message for this station.
    ///
    /// # Errors
    /// Where it names what the station does not have, or something is no number.
    pub fn read(station: &Station, text: &str) -> Result<Self, ConfirmationError> {
        let mut lines = text.split('\n').map(str::trim);
        let at = place(station, lines.next().unwrap_or_default())?;
        let numbers = lines.filter(|line| !line.is_empty()).map(Confirmation::number);
        let numbers: Vec<_> = numbers.take(PARAMETERS_MAX + 1).collect::<Result<_, _>>()?;
        if numbers.len() > PARAMETERS_MAX { Err(ConfirmationError::TooMany) } else { Ok(Confirmation { at, numbers }) }
    }

    /// Reads `slot=2`.
    ///
    /// # Errors
    /// Where it is no name with a number.
    pub fn number(text: &str) -> Result<(Arc<str>, i32), ConfirmationError> {
        let parts = text.split_once('=').map(|(name, number)| (name.trim(), number.trim().parse().ok()));
        match parts {
            Some((name, Some(number))) if !name.is_empty() => Ok((name.into(), number)),
            _ => Err(ConfirmationError::NotANumber { text: quoted(text) }),
        }
    }

    /// The text of its message.
    pub fn text(&self, station: &Station) -> String {
        let mut text = match self.at {
            RejoinAt::Measured => String::new(),
            RejoinAt::Within(op) => station.operations[op.index()].name.clone(),
            RejoinAt::Rest(rest) => format!("{REJOIN_AT_REST}{}", station.rests[rest.index()].name),
        };
        self.numbers.iter().for_each(|(name, number)| text.push_str(&format!("\n{name}={number}")));
        text
    }
}

fn place(station: &Station, name: &str) -> Result<RejoinAt, ConfirmationError> {
    if let Some(name) = name.strip_prefix(REJOIN_AT_REST) {
        let known = || station.rests.iter().map(|rest| rest.name.as_str()).collect::<Vec<_>>().join(", ");
        let unknown = || ConfirmationError::UnknownRest { name: quoted(name), known: known() };
        return station.rest_named(name).map(RejoinAt::Rest).ok_or_else(unknown);
    }
    if name.is_empty() {
        return Ok(RejoinAt::Measured);
    }
    let known = || station.operations.iter().map(|of| of.name.as_str()).collect::<Vec<_>>().join(", ");
    let unknown = || ConfirmationError::UnknownOperation { name: quoted(name), known: known() };
    station.operation_named(name).map(RejoinAt::Within).ok_or_else(unknown)
}
