//! Any text as a parameter file of ROS 2: values with their places or problems, never a panic; and put into the parameters of a node,
//! each value is one that was declared.

#![cfg_attr(feature = "engine", no_main)]

use libfuzzer_sys::fuzz_target;
use linewright_fuzz::draw_foreign;
use linewright_parameters::{
    Declaration, OverrideError, ParameterChange, ParameterDomain, ParameterFile, ParameterSet, ParameterValue, apply,
    argument_value,
};

/// No drawing of the most problems that are kept is longer.
const DRAWN_MAX: usize = 4_000_000;

const PERIOD: Declaration = Declaration {
    name: "report.period_s",
    domain: ParameterDomain::Double { from: 0.5, to: 10.0 },
    change: ParameterChange::Live,
    description: "Period of reports, in s.",
};

fuzz_target!(|text: &str| {
    let _ = argument_value(text);
    let mut set = ParameterSet::new([(&PERIOD, ParameterValue::Double(1.0))]);
    match ParameterFile::read("any.yaml", text) {
        Ok(file) => {
            if let Err(OverrideError::File(problems)) = apply(&mut set, &[file.into()], "/hall/drill", &[]) {
                draw_foreign(text.as_bytes(), &problems, DRAWN_MAX);
            }
        }
        Err(problems) => draw_foreign(text.as_bytes(), &problems, DRAWN_MAX),
    }
    assert!(set.double(PERIOD.name).is_some_and(|period| (0.5..=10.0).contains(&period)));
});

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
