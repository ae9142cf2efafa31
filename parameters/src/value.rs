//! Values of parameters.

use std::fmt;

/// Type of a parameter's value. The numbers are those of `rcl_interfaces/ParameterType`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterType {
    /// No value.
    NotSet = 0,
    Bool = 1,
    /// 64 bits, signed.
    Integer = 2,
    Double = 3,
    Text = 4,
    ByteArray = 5,
    BoolArray = 6,
    IntegerArray = 7,
    DoubleArray = 8,
    TextArray = 9,
}

impl ParameterType {
    const ALL: [ParameterType; 10] = [
        ParameterType::NotSet,
        ParameterType::Bool,
        ParameterType::Integer,
        ParameterType::Double,
        ParameterType::Text,
        ParameterType::ByteArray,
        ParameterType::BoolArray,
        ParameterType::IntegerArray,
        ParameterType::DoubleArray,
        ParameterType::TextArray,
    ];

    /// Its number in messages.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// The type with a number of a message; an unknown one means no value.
    pub fn of_code(code: u8) -> Self {
        Self::ALL.get(usize::from(code)).copied().unwrap_or(ParameterType::NotSet)
    }

    /// Noun phrase with its article.
    pub fn phrase(self) -> &'static str {
        match self {
            ParameterType::NotSet => "an unset value",
            ParameterType::Bool => "a bool",
            ParameterType::Integer => "an integer",
            ParameterType::Double => "a double",
            ParameterType::Text => "a string",
            ParameterType::ByteArray => "a byte array",
            ParameterType::BoolArray => "a bool array",
            ParameterType::IntegerArray => "an integer array",
            ParameterType::DoubleArray => "a double array",
            ParameterType::TextArray => "a string array",
        }
    }
}

/// Value of a parameter. A parameter here has one of the first four types; what a request or a file has besides is kept as its
/// type alone, which is enough to refuse it.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    Bool(bool),
    Integer(i64),
    Double(f64),
    Text(String),
    /// Of a type that no parameter here has.
    Other(ParameterType),
}

impl ParameterValue {
    /// Its type.
    pub fn kind(&self) -> ParameterType {
        match self {
            ParameterValue::Bool(_) => ParameterType::Bool,
            ParameterValue::Integer(_) => ParameterType::Integer,
            ParameterValue::Double(_) => ParameterType::Double,
            ParameterValue::Text(_) => ParameterType::Text,
            ParameterValue::Other(kind) => *kind,
        }
    }
}

/// As in a file, but for texts, which are cut and in quotation marks.
impl fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterValue::Bool(value) => value.fmt(f),
            ParameterValue::Integer(value) => value.fmt(f),
            ParameterValue::Double(value) => write!(f, "{value:?}"),
            ParameterValue::Text(value) => write!(f, "'{}'", linewright_diagnostics::shown(value)),
            ParameterValue::Other(kind) => f.write_str(kind.phrase()),
        }
    }
}
