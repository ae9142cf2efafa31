//! Errors in requests about production orders.

use std::fmt;

use crate::orders::ProductionCommandError;
use crate::production::{NAME_MAX, ORDERS_MAX, ProductionRefusal, QUANTITY_MAX, RequestProblem};
use crate::texts::decision::tenths;

impl fmt::Display for RequestProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RequestProblem::Name(name) => {
                write!(f, "order name `{name}` not valid: 1 to {NAME_MAX} characters, one line")
            }
            RequestProblem::NameTaken(name) => {
                write!(f, "order name `{name}` in use; choose another, or wait until that order is finished")
            }
            RequestProblem::NameTwice(name) => {
                write!(f, "order name `{name}` requested twice with different keys; choose another for one")
            }
            RequestProblem::KeyTaken { name, other } => write!(
                f,
                "order `{name}`: key already used by `{other}` with other content; use a new key for each request"
            ),
            RequestProblem::Product { name, product, hint } => {
                write!(f, "order `{name}`: no product `{product}`{}", advice(hint))
            }
            RequestProblem::Quantity { name, quantity } => {
                write!(f, "order `{name}`: quantity {quantity}, allowed 1 to {QUANTITY_MAX}")
            }
            RequestProblem::DueBeforeRelease { name, due, release } => {
                let early = tenths(release.since(*due).as_secs_f64());
                write!(f, "order `{name}`: due {early} s before its release")
            }
            RequestProblem::NoSuchOrder { name, after, hint } => {
                write!(f, "order `{name}`: no predecessor `{after}`{}", advice(hint))
            }
            RequestProblem::AfterWithdrawn { name, after } => {
                write!(f, "order `{name}`: predecessor `{after}` was withdrawn")
            }
            RequestProblem::Circle(names) => write!(f, "predecessors form a circle: {}", circle(names)),
            RequestProblem::TooMany { open } => {
                write!(f, "{open} open orders, at most {ORDERS_MAX}; wait until some are finished")
            }
        }
    }
}

impl std::error::Error for RequestProblem {}

impl fmt::Display for ProductionRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ProductionRefusal::Unknown { name, hint } => write!(f, "no order `{name}`{}", advice(hint)),
            ProductionRefusal::Over(name) => write!(f, "order `{name}` is already finished or cancelled"),
            ProductionRefusal::Begun { name, entered } => {
                write!(f, "order `{name}` cannot be withdrawn: {entered} of its parts have entered; cancel it instead")
            }
            ProductionRefusal::Needed { name, by } => {
                write!(f, "order `{name}` is the predecessor of `{by}`; withdraw that first, or cancel this one")
            }
        }
    }
}

impl std::error::Error for ProductionRefusal {}

impl fmt::Display for ProductionCommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ProductionCommandError::Request(problems) => {
                f.write_str(&problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
            }
            ProductionCommandError::Order(refusal) => refusal.fmt(f),
            ProductionCommandError::Superseded => {
                f.write_str("rejected: another coordinator was started later; send the request to that one")
            }
        }
    }
}

impl std::error::Error for ProductionCommandError {}

fn advice(hint: &Option<String>) -> String {
    hint.as_ref().map(|hint| format!("; {hint}")).unwrap_or_default()
}

fn circle(names: &[String]) -> String {
    let first = names.first().cloned().into_iter();
    names.iter().cloned().chain(first).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" after ")
}
