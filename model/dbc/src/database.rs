//! A DBC file as messages and signals, as far as frames can be read and written by them.

use std::fmt;

use can_dbc::{ByteOrder, Dbc, MessageId, MultiplexIndicator, NumericValue, SignalExtendedValueType, ValueType};
use linewright_line::{Coding, FrameField, FrameId};
use thiserror::Error;

/// A larger file is refused; those of whole vehicles have a few megabytes.
pub const FILE_BYTES_MAX: usize = 16 << 20;

/// Reason why a file is no database.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum DbcError {
    /// It has too many bytes.
    #[error("it has {0} bytes; {FILE_BYTES_MAX} are read at most")]
    TooLong(usize),
    /// It does not follow the grammar.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// Text expected there.
        message: String,
    },
    /// It follows the grammar, but its contents are impossible.
    #[error("{0}")]
    Content(String),
}

/// The messages of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Database {
    /// In the order of the file.
    pub messages: Vec<DbcMessage>,
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct DbcMessage {
    pub name: String,
    /// Its identifier.
    pub id: FrameId,
    /// Its bytes; a classic frame has up to 8.
    pub len: u64,
    pub signals: Vec<DbcSignal>,
}

/// A signal.
#[derive(Clone, Debug, PartialEq)]
pub struct DbcSignal {
    pub name: String,
    /// Its place. `None` for a signal that no frame of eight bytes holds, or whose factor is 0.
    pub field: Option<FrameField>,
    /// Whether it is always there.
    pub mux: Mux,
    /// The least and the greatest value, if the file has them: `[0|0]`, or any two that are no range, count as none.
    pub limits: Option<(f64, f64)>,
    pub unit: String,
}

/// Whether a signal is always there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mux {
    /// Not multiplexed.
    Plain,
    /// It is, and selects others.
    Selector,
    /// Only when the selector of the message has one of these values.
    Selected(Vec<(u64, u64)>),
    /// Only when a selector, itself selected, has some value. Not supported.
    Nested,
}

impl DbcMessage {
    /// The signal that selects others, if there is one in its eight bytes, and its place.
    pub fn selector(&self) -> Option<(&DbcSignal, FrameField)> {
        let selector = self.signals.iter().find(|signal| signal.mux == Mux::Selector)?;
        Some((selector, selector.field.filter(|field| u8::try_from(self.len).is_ok_and(|len| field.fits(len)))?))
    }
}

impl fmt::Display for DbcMessage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {} bytes)", self.name, self.id, self.len)
    }
}

/// Reads a file: UTF-8, or else Latin 1, which old tools write.
pub fn read(bytes: &[u8]) -> Result<Database, DbcError> {
    if bytes.len() > FILE_BYTES_MAX {
        return Err(DbcError::TooLong(bytes.len()));
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    };
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(&text);
    let dbc = Dbc::try_from(text).map_err(error)?;
    Ok(Database { messages: dbc.messages.iter().map(|raw| message(&dbc, raw)).collect() })
}

fn error(error: can_dbc::DbcError) -> DbcError {
    let can_dbc::DbcError::Pest(error) = error else { return DbcError::Content(error.to_string()) };
    // The library's own type for the place is not exported, its picture is: " --> line:column" on the first line.
    let drawn = error.to_string();
    let place = drawn.lines().next().and_then(|first| first.split_once("--> ")).and_then(|(_, at)| at.split_once(':'));
    let number = |text: &str| text.trim().parse().ok();
    let (line, column) = place.and_then(|(line, column)| Some((number(line)?, number(column)?))).unwrap_or((1, 1));
    DbcError::Syntax { line, column, message: error.variant.message().into_owned() }
}

fn message(dbc: &Dbc, raw: &can_dbc::Message) -> DbcMessage {
    let id = match raw.id {
        MessageId::Standard(id) => FrameId { id: id.into(), extended: false },
        MessageId::Extended(id) => FrameId { id, extended: true },
    };
    let signals = raw.signals.iter().map(|signal| self::signal(dbc, raw, signal)).collect();
    DbcMessage { name: raw.name.clone(), id, len: raw.size, signals }
}

fn signal(dbc: &Dbc, message: &can_dbc::Message, raw: &can_dbc::Signal) -> DbcSignal {
    let extended = dbc
        .signal_extended_value_type_list
        .iter()
        .find(|list| list.message_id == message.id && list.signal_name == raw.name)
        .map(|list| list.signal_extended_value_type);
    let coding = match (extended, raw.value_type) {
        (Some(SignalExtendedValueType::IEEEfloat32Bit), _) => Coding::Float,
        (Some(SignalExtendedValueType::IEEEdouble64bit), _) => Coding::Double,
        (_, ValueType::Signed) => Coding::Signed,
        (_, ValueType::Unsigned) => Coding::Unsigned,
    };
    let (least, most) = (number(raw.min), number(raw.max));
    DbcSignal {
        name: raw.name.clone(),
        field: field(raw, coding),
        mux: mux(dbc, message, raw),
        limits: (least < most).then_some((least, most)),
        unit: raw.unit.clone(),
    }
}

fn number(raw: NumericValue) -> f64 {
    match raw {
        NumericValue::Uint(number) => number as f64,
        NumericValue::Int(number) => number as f64,
        NumericValue::Double(number) => number,
    }
}

fn field(raw: &can_dbc::Signal, coding: Coding) -> Option<FrameField> {
    let field = FrameField {
        start: u8::try_from(raw.start_bit).ok().filter(|start| *start < 64)?,
        size: u8::try_from(raw.size).ok()?,
        motorola: raw.byte_order == ByteOrder::BigEndian,
        coding,
        factor: raw.factor,
        offset: raw.offset,
    };
    let width = match coding {
        Coding::Float => field.size == 32,
        Coding::Double => field.size == 64,
        Coding::Signed | Coding::Unsigned => true,
    };
    let scaled = field.factor.is_finite() && field.factor != 0.0 && field.offset.is_finite();
    (width && scaled && field.fits(8)).then_some(field)
}

fn mux(dbc: &Dbc, message: &can_dbc::Message, raw: &can_dbc::Signal) -> Mux {
    let extended = dbc.extended_multiplex.iter().find(|e| e.message_id == message.id && e.signal_name == raw.name);
    let selects = |name: &str| {
        let named = message.signals.iter().find(|signal| signal.name == name);
        named.is_some_and(|signal| signal.multiplexer_indicator == MultiplexIndicator::Multiplexor)
    };
    match (raw.multiplexer_indicator, extended) {
        (MultiplexIndicator::Plain, _) => Mux::Plain,
        (MultiplexIndicator::Multiplexor, _) => Mux::Selector,
        (MultiplexIndicator::MultiplexedSignal(_), Some(extended)) if selects(&extended.multiplexor_signal_name) => {
            Mux::Selected(extended.mappings.iter().map(|range| (range.min_value, range.max_value)).collect())
        }
        (MultiplexIndicator::MultiplexedSignal(value), None) => Mux::Selected(vec![(value, value)]),
        _ => Mux::Nested,
    }
}
