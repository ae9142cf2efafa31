//! What may be set, and to what.

use linewright_parameters::{
    Declaration, ParameterChange, ParameterDomain, ParameterSet, ParameterType, ParameterValue, Refusal,
};
use proptest::prelude::*;

pub const LEVEL: Declaration = Declaration {
    name: "level",
    domain: ParameterDomain::OneOf(&["low", "high"]),
    change: ParameterChange::Live,
    description: "How much.",
};
pub const COUNT: Declaration = Declaration {
    name: "rate.count",
    domain: ParameterDomain::Integer { from: -3, to: 7 },
    change: ParameterChange::Live,
    description: "How many.",
};
pub const PERIOD: Declaration = Declaration {
    name: "rate.period_s",
    domain: ParameterDomain::Double { from: 0.5, to: 10.0 },
    change: ParameterChange::Live,
    description: "How often, in s.",
};
pub const LEASE: Declaration = Declaration {
    name: "timing.lease_ms",
    domain: ParameterDomain::Integer { from: 1, to: 60_000 },
    change: ParameterChange::Elsewhere("lease_ms in [timing] of line.toml"),
    description: "How long, in ms.",
};
pub const BUS: Declaration = Declaration {
    name: "bus",
    domain: ParameterDomain::Text,
    change: ParameterChange::AtStart("--bus"),
    description: "Which bus.",
};
pub const QUIET: Declaration = Declaration {
    name: "quiet",
    domain: ParameterDomain::Bool,
    change: ParameterChange::Live,
    description: "Whether.",
};

pub fn set() -> ParameterSet {
    ParameterSet::new([
        (&LEVEL, ParameterValue::Text("low".into())),
        (&COUNT, ParameterValue::Integer(1)),
        (&PERIOD, ParameterValue::Double(1.0)),
        (&LEASE, ParameterValue::Integer(500)),
        (&BUS, ParameterValue::Text("vcan0".into())),
        (&QUIET, ParameterValue::Bool(false)),
    ])
}

fn text(text: &str) -> ParameterValue {
    ParameterValue::Text(text.to_owned())
}

#[test]
fn a_refused_change_says_why() {
    for (name, value, expected) in [
        ("level", text("loud"), "level is one of low, high, and not 'loud'"),
        ("level", ParameterValue::Integer(1), "level is a string, and not an integer"),
        ("rate.count", ParameterValue::Integer(8), "rate.count is from -3 to 7, and not 8"),
        ("rate.period_s", ParameterValue::Double(0.4), "rate.period_s is from 0.5 to 10.0, and not 0.4"),
        ("rate.period_s", ParameterValue::Double(f64::NAN), "rate.period_s is from 0.5 to 10.0, and not NaN"),
        ("rate.period_s", ParameterValue::Integer(2), "rate.period_s is a double, and not an integer; write 2.0"),
        ("quiet", ParameterValue::Other(ParameterType::NotSet), "quiet is a bool, and not an unset value"),
        (
            "timing.lease_ms",
            ParameterValue::Integer(400),
            "timing.lease_ms is read-only, and is 500; it is set by lease_ms in [timing] of line.toml",
        ),
        ("bus", text("can1"), "bus is read-only while the node runs, and is 'vcan0'; it is set at the start: --bus"),
        (
            "rate.periods",
            ParameterValue::Double(1.0),
            "rate.periods is no parameter of this node; did you mean rate.period_s?",
        ),
        ("x", text("x"), "x is no parameter of this node"),
    ] {
        let mut set = set();
        let refused = set.set(name, &value).expect_err("it is refused");
        assert_eq!(refused.to_string(), expected);
        assert_eq!(set, self::set(), "nothing has changed");
    }
}

#[test]
fn what_was_dumped_is_taken_again() {
    let mut set = set();
    for (declared, value) in self::set().iter() {
        assert_eq!(set.set(declared.name, value), Ok(false), "{}", declared.name);
    }
    assert_eq!(set, self::set());
}

#[test]
fn names_are_listed_as_in_rclcpp() {
    let names = |prefixes: &[&str], depth| {
        let prefixes: Vec<String> = prefixes.iter().map(|prefix| (*prefix).to_owned()).collect();
        set().list(&prefixes, depth)
    };
    let all = ["bus", "level", "quiet", "rate.count", "rate.period_s", "timing.lease_ms"];
    assert_eq!(names(&[], 0), (all.to_vec(), vec!["rate", "timing"]));
    assert_eq!(names(&[], 1), (vec!["bus", "level", "quiet"], vec![]));
    assert_eq!(names(&["rate"], 0), (vec!["rate.count", "rate.period_s"], vec!["rate"]));
    assert_eq!(names(&["rate"], 1), (vec![], vec![]), "the dot behind the beginning counts");
    assert_eq!(names(&["rate", "bus"], 2), (vec!["bus", "rate.count", "rate.period_s"], vec!["rate"]));
    assert_eq!(names(&["rat"], 0), (vec![], vec![]));
}

fn value() -> impl Strategy<Value = ParameterValue> {
    prop_oneof![
        any::<bool>().prop_map(ParameterValue::Bool),
        (-10..20_i64).prop_map(ParameterValue::Integer),
        any::<i64>().prop_map(ParameterValue::Integer),
        any::<f64>().prop_map(ParameterValue::Double),
        (0.0..11.0).prop_map(ParameterValue::Double),
        prop::sample::select(vec!["low", "high", "other"]).prop_map(text),
        Just(ParameterValue::Other(ParameterType::IntegerArray)),
    ]
}

fn name() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec!["level", "rate.count", "rate.period_s", "timing.lease_ms", "bus", "quiet", "unknown"])
}

proptest! {
    /// Whatever is sent in whatever order, each value is one that was declared, and what is read-only stands.
    #[test]
    fn no_request_leaves_what_is_declared(changes in prop::collection::vec((name(), value()), 0..20)) {
        let mut set = set();
        for (name, value) in &changes {
            let before = set.clone();
            match set.set(name, value) {
                Ok(is_other) => {
                    prop_assert_eq!(set.get(name), Some(value));
                    prop_assert_eq!(is_other, before.get(name) != Some(value));
                }
                Err(_) => prop_assert_eq!(&set, &before),
            }
        }
        prop_assert_eq!(set.get("timing.lease_ms"), Some(&ParameterValue::Integer(500)));
        prop_assert_eq!(set.get("bus"), Some(&text("vcan0")));
        let count = matches!(set.get("rate.count"), Some(ParameterValue::Integer(-3..=7)));
        let period = set.double("rate.period_s").is_some_and(|period| (0.5..=10.0).contains(&period));
        let level = matches!(set.text("level"), Some("low" | "high"));
        prop_assert!(count && period && level, "{:?}", set);
    }

    /// All at once is as one by one, unless any of them is refused: then nothing is.
    #[test]
    fn several_are_set_all_or_none(changes in prop::collection::vec((name(), value()), 0..6)) {
        let (mut together, mut one_by_one) = (set(), set());
        let pairs = changes.iter().map(|(name, value)| (*name, value));
        let first: Result<Vec<bool>, Refusal> = pairs.clone().map(|(name, value)| one_by_one.set(name, value)).collect();
        match together.set_all(pairs) {
            Ok(changed) => {
                prop_assert!(first.is_ok());
                prop_assert_eq!(&together, &one_by_one);
                for (declared, value) in set().iter() {
                    let is_other = together.get(declared.name) != Some(value);
                    prop_assert_eq!(changed.contains(&declared.name), is_other, "{}", declared.name);
                }
            }
            Err(refused) => {
                prop_assert_eq!(Some(refused), first.err());
                prop_assert_eq!(together, set());
            }
        }
    }
}
