//! Values as YAML has them, by the rules of ROS 2 (`rcl_yaml_param_parser`).

use crate::file::yaml::{YamlKind, YamlNode, document};
use crate::{ParameterType, ParameterValue};

const TRUE: [&str; 11] = ["Y", "y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"];
const FALSE: [&str; 11] = ["N", "n", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF"];

/// The value that an argument `name:=value` gives: one scalar, or a list.
///
/// # Errors
/// A sentence, when it is neither.
pub fn argument_value(text: &str) -> Result<ParameterValue, String> {
    match document(text) {
        Ok(Some(node)) if !matches!(node.kind, YamlKind::Map(_)) => Ok(value(&node)),
        Ok(None) => Ok(ParameterValue::Other(ParameterType::NotSet)),
        Ok(Some(_)) => Err("a map is no value of a parameter".to_owned()),
        Err(error) => Err(error.message),
    }
}

/// Value of a node that is no map. A list keeps its type alone, which is that of its first item.
pub(crate) fn value(node: &YamlNode) -> ParameterValue {
    match &node.kind {
        YamlKind::Plain(text) => plain(text),
        YamlKind::Quoted(text) => ParameterValue::Text(text.clone()),
        YamlKind::List(items) => ParameterValue::Other(match items.first().map(|first| value(first).kind()) {
            Some(ParameterType::Bool) => ParameterType::BoolArray,
            Some(ParameterType::Integer) => ParameterType::IntegerArray,
            Some(ParameterType::Double) => ParameterType::DoubleArray,
            _ => ParameterType::TextArray,
        }),
        YamlKind::Map(_) => ParameterValue::Other(ParameterType::NotSet),
    }
}

fn plain(text: &str) -> ParameterValue {
    if matches!(text, "" | "~" | "null") {
        return ParameterValue::Other(ParameterType::NotSet);
    }
    if TRUE.contains(&text) || FALSE.contains(&text) {
        return ParameterValue::Bool(TRUE.contains(&text));
    }
    if let Some(value) = integer(text) {
        return ParameterValue::Integer(value);
    }
    match double(text) {
        Some(value) => ParameterValue::Double(value),
        None => ParameterValue::Text(text.to_owned()),
    }
}

/// Decimal, hexadecimal with `0x`, or octal with a leading zero, as `strtoll` reads them.
fn integer(text: &str) -> Option<i64> {
    let (sign, digits) = match text.strip_prefix(['-', '+']) {
        Some(digits) => (if text.starts_with('-') { "-" } else { "" }, digits),
        None => ("", text),
    };
    let (digits, radix) = match digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
        Some(digits) => (digits, 16),
        None if digits.len() > 1 && digits.starts_with('0') => (digits, 8),
        None => (digits, 10),
    };
    // A second sign would be read as one.
    let is_number = digits.starts_with(|c: char| c.is_digit(radix));
    is_number.then(|| i64::from_str_radix(&format!("{sign}{digits}"), radix).ok()).flatten()
}

fn double(text: &str) -> Option<f64> {
    match text {
        ".nan" | ".NaN" | ".NAN" => Some(f64::NAN),
        ".inf" | ".Inf" | ".INF" | "+.inf" | "+.Inf" | "+.INF" => Some(f64::INFINITY),
        "-.inf" | "-.Inf" | "-.INF" => Some(f64::NEG_INFINITY),
        // Rust also reads `inf` and `nan` as numbers; YAML writes those with a dot.
        _ if text.contains(|c: char| c.is_ascii_digit()) => text.parse().ok(),
        _ => None,
    }
}
