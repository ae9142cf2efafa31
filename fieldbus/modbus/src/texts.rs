//! The texts about Modbus devices for operators and logs. All of them are here; `tests/texts.rs` keeps a list of them.
//!
//! A text about a device follows its name: what happened, and what follows or what to do where that is not plain.

use std::fmt;
use std::time::Duration;

use linewright_line::Table;

use crate::message::{ModbusFailure, ModbusRequest};

/// Why a device is not operational.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusTrouble {
    /// No request was sent for longer than a cycle may take: this program or its machine stood still.
    NotAsked(Duration),
    /// Its watchdog may have run out, since it was last written so long ago.
    WatchdogUnwritten(Duration),
    /// Within this time it took no connection.
    NotConnected(Duration),
    Unanswered {
        request: ModbusRequest,
        within: Duration,
    },
    /// Its outputs were read back, and are not those that were written.
    OutputsChanged {
        found: u64,
        written: u64,
    },
    /// A register that identifies it has another value.
    OtherDevice {
        register: u16,
        found: u64,
        expected: u16,
    },
    /// A request failed; without one, connecting did.
    Failed {
        request: Option<ModbusRequest>,
        failure: ModbusFailure,
    },
    /// It was reset by request.
    Reset,
}

impl ModbusTrouble {
    /// It answers, but not what it should.
    pub fn is_refusal(&self) -> bool {
        match self {
            ModbusTrouble::OutputsChanged { .. } | ModbusTrouble::OtherDevice { .. } => true,
            ModbusTrouble::Failed { failure, .. } => !matches!(failure, ModbusFailure::Gone(_)),
            ModbusTrouble::NotAsked(_)
            | ModbusTrouble::WatchdogUnwritten(_)
            | ModbusTrouble::NotConnected(_)
            | ModbusTrouble::Unanswered { .. }
            | ModbusTrouble::Reset => false,
        }
    }
}

impl fmt::Display for ModbusTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModbusTrouble::NotAsked(time) => write!(f, "not asked for {} ms", time.as_millis()),
            ModbusTrouble::WatchdogUnwritten(time) => {
                write!(f, "its watchdog was not written for {} ms and may have run out", time.as_millis())
            }
            ModbusTrouble::NotConnected(within) => {
                write!(f, "it does not take a connection within {} ms", within.as_millis())
            }
            ModbusTrouble::Unanswered { request, within } => {
                write!(f, "no answer within {} ms ({request})", within.as_millis())
            }
            ModbusTrouble::OutputsChanged { found, written } => write!(
                f,
                "its outputs are {found:X}h, where {written:X}h was written: another master writes them, or the device \
                 has changed them by itself"
            ),
            ModbusTrouble::OtherDevice { register, found, expected } => {
                write!(f, "another device: holding register {register} is {found}, expected {expected}")
            }
            ModbusTrouble::Failed { request, failure } => failed(f, request.as_ref(), failure),
            ModbusTrouble::Reset => f.write_str("reset by request"),
        }
    }
}

fn failed(f: &mut fmt::Formatter<'_>, request: Option<&ModbusRequest>, failure: &ModbusFailure) -> fmt::Result {
    let doing = request.map_or_else(|| "connecting".to_owned(), ModbusRequest::to_string);
    match failure {
        ModbusFailure::Gone(error) => write!(f, "no connection: {error}"),
        ModbusFailure::Exception(code) => {
            // The two by which a device reports that there is nothing at an address, or not so much.
            let map = if matches!(code, 2 | 3) { "wrong register map: " } else { "" };
            write!(f, "{map}{doing} is refused: {} (exception {code})", exception_text(*code))
        }
        ModbusFailure::Malformed(error) => write!(f, "{doing}: {error}"),
        ModbusFailure::OtherAnswer => write!(f, "{doing}: the answer does not belong to it"),
        ModbusFailure::Count { came, count } => {
            write!(f, "{doing}: wrong register map: {came} came, {count} were asked for")
        }
    }
}

/// State of a device, for its diagnosis and for why its owner's inputs are invalid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusCondition<'a> {
    /// Not operational; with the time until it is tried again.
    Down {
        trouble: &'a ModbusTrouble,
        retry: Option<Duration>,
    },
    Connecting,
    /// Connected, not yet operational: the pending request.
    Preparing(ModbusRequest),
    /// Operational, and this request is pending for too long.
    Unanswered(ModbusRequest),
    /// Operational, and no request was sent for too long.
    Unasked,
    /// Operational, with answers that take longer than a cycle.
    Slow {
        took: Duration,
        cycle: Duration,
    },
    Operational {
        /// Age of its inputs; none of a device that has none.
        inputs: Option<Duration>,
    },
}

impl fmt::Display for ModbusCondition<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModbusCondition::Down { trouble, retry: Some(retry) } => {
                write!(f, "{trouble}; tried again in {} ms", retry.as_millis())
            }
            ModbusCondition::Down { trouble, retry: None } => trouble.fmt(f),
            ModbusCondition::Connecting => f.write_str("it is being connected to"),
            ModbusCondition::Preparing(request) => write!(f, "connected; {request}"),
            ModbusCondition::Unanswered(request) => write!(f, "no answer yet ({request})"),
            ModbusCondition::Unasked => f.write_str("not asked for too long"),
            ModbusCondition::Slow { took, cycle } => write!(f, "operational, but slow: {}", Pace(*took, *cycle)),
            ModbusCondition::Operational { inputs: Some(age) } => {
                write!(f, "operational; its inputs came {} ms ago", age.as_millis())
            }
            ModbusCondition::Operational { inputs: None } => f.write_str("operational"),
        }
    }
}

/// Time that an answer took, and the cycle that it has to fit into.
struct Pace(Duration, Duration);

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an answer took {} ms, in a cycle of {} ms", self.0.as_millis(), self.1.as_millis())
    }
}

/// Report about a device for the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModbusNote<'a> {
    Operational,
    Lost(&'a ModbusTrouble),
    NotStarted(&'a ModbusTrouble),
    Slow { took: Duration, cycle: Duration },
    SlowNoLonger,
}

impl fmt::Display for ModbusNote<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModbusNote::Operational => f.write_str("is operational"),
            ModbusNote::Lost(trouble) => write!(f, "is lost: {trouble}"),
            ModbusNote::NotStarted(trouble) => write!(f, "is not started: {trouble}"),
            ModbusNote::Slow { took, cycle } => write!(f, "is slow: {}", Pace(*took, *cycle)),
            ModbusNote::SlowNoLonger => f.write_str("is slow no longer"),
        }
    }
}

/// Reply to a request about a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModbusServiceReply {
    Reset,
    Started,
    TriedAgain,
    NoObjects,
}

impl ModbusServiceReply {
    pub fn text(self) -> &'static str {
        match self {
            ModbusServiceReply::Reset => "its outputs are let go, and it is connected to anew",
            ModbusServiceReply::Started => "operational",
            ModbusServiceReply::TriedAgain => "it is being looked at again",
            ModbusServiceReply::NoObjects => "it speaks Modbus, and has no objects",
        }
    }
}

/// Meaning of an exception code (§7).
pub fn exception_text(code: u8) -> &'static str {
    match code {
        1 => "illegal function",
        2 => "illegal data address",
        3 => "illegal data value",
        4 => "device failure",
        5 => "acknowledge",
        6 => "device busy",
        8 => "memory parity error",
        10 => "gateway path unavailable",
        11 => "gateway target does not respond",
        _ => "unknown",
    }
}

impl fmt::Display for ModbusRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, count, table, first) = match self {
            ModbusRequest::Read { table, first, count } => ("reading", count, *table, first),
            ModbusRequest::WriteCoils { first, count, .. } => ("writing", count, Table::Coils, first),
            ModbusRequest::WriteRegisters { first, count, .. } => ("writing", count, Table::HoldingRegisters, first),
        };
        write!(f, "{what} {count} {table} from {first}")
    }
}
