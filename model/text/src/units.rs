//! The unit that the name of a key ends with, where it is misspelled by another one: `time_ms` for `time_s`.

use toml_edit::Item;

use crate::nearest;

/// Endings of keys, each with its unit and how much of a second that is.
const UNITS: [(&str, &str, f64); 3] =
    [("_ms", "milliseconds", 1e-3), ("_us", "microseconds", 1e-6), ("_s", "seconds", 1.0)];

fn unit(key: &str) -> Option<(&'static str, f64)> {
    UNITS.iter().find(|(ending, ..)| key.ends_with(ending)).map(|&(_, name, seconds)| (name, seconds))
}

/// What a value under `written` is multiplied by to be one under `key`; 1 where one of them names no unit.
pub(crate) fn factor(written: &str, key: &str) -> f64 {
    match (unit(written), unit(key)) {
        (Some((_, of)), Some((_, to))) if of != to => of / to,
        _ => 1.0,
    }
}

/// How the value of an unknown key is written under the nearest one of those that are known; none if that has the same unit.
pub(crate) fn rewritten(written: &str, known: &[&str], item: &Item) -> Option<String> {
    let key = nearest(written, known.iter().copied())?;
    let factor = factor(written, key);
    let value = item.as_float().or_else(|| item.as_integer().map(|whole| whole as f64))?;
    let (name, _) = unit(key)?;
    // The factor is not exact.
    let value = (value * factor * 1e9).round() / 1e9;
    (factor != 1.0).then(|| format!("write `{key} = {value}`, in {name}"))
}
