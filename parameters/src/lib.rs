//! The parameters of a ROS 2 node: declarations, what they may be set to, and the files and arguments that set them at the start.
//!
//! A node declares its parameters as a table of constants ([`Declaration`]) and holds their values in a [`ParameterSet`]. A value
//! is set at the start by an [`Override`]: of a [`ParameterFile`], or of an argument `name:=value`. While the node runs, a
//! request may change those that are [`ParameterChange::Live`]. Everything else is refused with the reason, and with the place where it is set.
//! A file has the form of ROS 2: sections for nodes, whose names may have wildcards ([`NodePattern`]).
//!
//! This crate knows no parameter of any node, no message, and reads no file: text comes in.
//!
//! ```
//! use linewright_parameters::{ParameterChange, Declaration, ParameterDomain, ParameterFile, ParameterSet, ParameterValue, apply};
//!
//! const PERIOD: Declaration = Declaration {
//!     name: "report.period_s",
//!     domain: ParameterDomain::Double { from: 0.5, to: 10.0 },
//!     change: ParameterChange::Live,
//!     description: "Period of reports, in s.",
//! };
//! let mut set = ParameterSet::new([(&PERIOD, ParameterValue::Double(1.0))]);
//! let file = ParameterFile::read("drill.yaml", "/**/drill:\n  ros__parameters: {report: {period_s: 2.5}}\n").unwrap();
//! apply(&mut set, &[file.into()], "/hall/drill", &[]).unwrap();
//! assert_eq!(set.get("report.period_s"), Some(&ParameterValue::Double(2.5)));
//! let refused = set.set("report.period_s", &ParameterValue::Double(99.0)).unwrap_err();
//! assert_eq!(refused.to_string(), "report.period_s is from 0.5 to 10.0, and not 99.0");
//! ```

mod declaration;
mod file;
mod overrides;
mod pattern;
mod scalar;
mod set;
mod value;

pub use linewright_diagnostics::Problems;

pub use declaration::{Declaration, ParameterChange, ParameterDomain};
pub use file::{FILE_BYTES_MAX, ParameterFile};
pub use overrides::{Argument, Override, OverrideError, apply};
pub use pattern::{NodePattern, PatternError};
pub use scalar::argument_value;
pub use set::{ParameterSet, Refusal};
pub use value::{ParameterType, ParameterValue};
