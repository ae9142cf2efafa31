//! Texts of SDO transfers and of bus scans for operators. `tests/texts.rs` keeps a list of them; those of a bus's manager
//! are in `manager/texts`.

use std::error::Error;
use std::fmt;
use std::time::Duration;

use linewright_line::Tick;

use crate::bus_scan::{PERIODS_MISSED, ScannedState};
use crate::codec::NmtState;
use crate::sdo::{TransferError, TransferFailure};

impl fmt::Display for TransferError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "object {}: {}", self.object, self.cause)
    }
}

impl Error for TransferError {}

impl fmt::Display for TransferFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TransferFailure::Refused(code) => write!(f, "refused: {code}"),
            TransferFailure::Silent { waited, done, asked } => {
                write!(f, "no answer within {} ms{}", waited.as_millis(), circumstances(*done, *asked))
            }
            TransferFailure::Toggle { done } => {
                write!(f, "a segment came twice or is missing (toggle bit) after {done} bytes")
            }
            TransferFailure::Sequence { number } => write!(f, "segment {number} of the block is out of sequence"),
            TransferFailure::BlockSize { size } => write!(f, "{size} segments in a block, expected 1 to 127"),
            TransferFailure::Crc { sent, computed } => {
                write!(f, "checksum {sent:04X}h, but the bytes received have {computed:04X}h")
            }
            TransferFailure::Length { announced, came } => write!(f, "{announced} bytes were announced, {came} came"),
            TransferFailure::TooLong { len_max } => write!(f, "longer than the {len_max} bytes that are taken"),
            TransferFailure::Command { command, done } => {
                write!(f, "answer {command:02X}h does not fit the transfer, after {done} bytes")
            }
            TransferFailure::Interrupted { by } => write!(f, "another client has asked the device for {by}"),
            TransferFailure::Cancelled => f.write_str("given up"),
        }
    }
}

impl Error for TransferFailure {}

fn circumstances(done: usize, asked: u8) -> String {
    match (done, asked) {
        (0, 0 | 1) => String::new(),
        (0, _) => format!(", asked {asked} times"),
        (_, _) => format!(" after {done} bytes"),
    }
}

impl ScannedState {
    /// Its state at `now` in one sentence.
    pub fn explain(&self, now: Tick) -> String {
        let mut sentence = match (self.state, self.heartbeat) {
            (Some(state), Some(at)) => self.alive(state, now.since(at)),
            _ => "sends, but no heartbeat: its state is unknown".to_owned(),
        };
        if let Some((at, emergency)) = self.emergency {
            let ago = Ago(now.since(at));
            let _ = fmt::Write::write_fmt(&mut sentence, format_args!("; {ago} ago it reported {emergency}"));
        }
        sentence
    }

    fn alive(&self, state: NmtState, silent: Duration) -> String {
        let name = state_name(state);
        match self.period {
            Some(period) if silent > period * PERIODS_MISSED => {
                format!(
                    "silent for {}, it was {name} and sent a heartbeat every {} ms",
                    Ago(silent),
                    period.as_millis()
                )
            }
            Some(period) => format!("{name}, a heartbeat every {} ms", period.as_millis()),
            None if state == NmtState::BootUp => format!("has booted {} ago, waits to be configured", Ago(silent)),
            None => format!("{name}, one heartbeat {} ago", Ago(silent)),
        }
    }
}

/// Name of a state.
pub fn state_name(state: NmtState) -> String {
    match state {
        NmtState::BootUp => "booted".to_owned(),
        NmtState::Stopped => "stopped".to_owned(),
        NmtState::Operational => "operational".to_owned(),
        NmtState::PreOperational => "pre-operational".to_owned(),
        NmtState::Unknown(code) => format!("in state {code:02X}h, which CiA 301 does not have"),
    }
}

/// A duration, in ms or s.
struct Ago(Duration);

impl fmt::Display for Ago {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_millis() {
            millis @ 0..10_000 => write!(f, "{millis} ms"),
            millis => write!(f, "{} s", millis / 1000),
        }
    }
}
