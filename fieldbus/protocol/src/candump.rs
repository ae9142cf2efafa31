//! Frames as the CAN tools write them: `181#0102`, and the log lines of `candump -L`.
//!
//! A recording made here can be replayed with `canplayer` and read by every tool that reads candump logs. This module
//! handles text only; the time of a line is an argument.

use std::fmt;
use std::io::{self, Write};
use std::str::FromStr;
use std::time::Duration;

use crate::frame::{Frame, FrameError, FrameKind};

/// Writes frames as `candump -L` does: `(1436509052.249713) vcan0 181#0102`.
pub struct CandumpWriter {
    interface: String,
    sink: Box<dyn Write + Send>,
    lost: u64,
}

impl CandumpWriter {
    /// A recorder of the bus `interface` that writes to `sink`, one line per frame, unbuffered: what a crash leaves
    /// behind is complete up to it.
    pub fn new(interface: &str, sink: Box<dyn Write + Send>) -> Self {
        CandumpWriter { interface: interface.to_owned(), sink, lost: 0 }
    }

    /// Writes one frame seen `since_epoch` after 1970-01-01. A sink that fails loses the line, never the frame:
    /// [`CandumpWriter::lost`] counts them.
    pub fn record(&mut self, since_epoch: Duration, frame: &Frame) {
        let line = log_line(since_epoch, &self.interface, frame);
        if self.sink.write_all(line.as_bytes()).and_then(|()| self.sink.write_all(b"\n")).is_err() {
            self.lost += 1;
        }
    }

    /// Lines the sink did not take.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Passes on what the sink holds back.
    pub fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

impl fmt::Debug for CandumpWriter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Recorder").field("interface", &self.interface).field("lost", &self.lost).finish()
    }
}

/// One line of a candump log, without its line end.
pub fn log_line(since_epoch: Duration, interface: &str, frame: &Frame) -> String {
    format!("({}.{:06}) {interface} {frame}", since_epoch.as_secs(), since_epoch.subsec_micros())
}

/// One line of a candump log: time since 1970-01-01, interface, frame. A direction mark after the frame is ignored.
pub fn parse_log_line(line: &str) -> Result<(Duration, String, Frame), FrameError> {
    let bad = |expected| FrameError::Text { text: line.to_owned(), expected };
    let mut words = line.split_whitespace();
    let stamp = words.next().and_then(|w| w.strip_prefix('(')?.strip_suffix(')')).ok_or(bad("(seconds.micros)"))?;
    let interface = words.next().ok_or(bad("an interface name"))?;
    let frame = words.next().ok_or(bad("a frame"))?.parse()?;
    let (seconds, micros) = stamp.split_once('.').ok_or(bad("(seconds.micros)"))?;
    let seconds: u64 = seconds.parse().map_err(|_| bad("(seconds.micros)"))?;
    let micros: u32 = micros.parse().ok().filter(|m| *m < 1_000_000).ok_or(bad("(seconds.micros)"))?;
    Ok((Duration::new(seconds, micros * 1000), interface.to_owned(), frame))
}

impl fmt::Display for Frame {
    /// `181#0102`; a remote request `701#R1`; eight digits for an extended identifier or an error frame.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = self.id_word();
        match self.kind() {
            FrameKind::Error(class) => write!(f, "{:08X}#", 0x2000_0000 | class)?,
            _ if word & 0x8000_0000 != 0 => write!(f, "{:08X}#", word & 0x1FFF_FFFF)?,
            _ => write!(f, "{:03X}#", word & 0x7FF)?,
        }
        if self.kind() == FrameKind::Remote {
            return if self.is_empty() { f.write_str("R") } else { write!(f, "R{}", self.len()) };
        }
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Frame({self})")
    }
}

impl FromStr for Frame {
    type Err = FrameError;

    /// Reads what `cansend` takes: `181#0102`, dots between bytes allowed, `701#R` for a remote request.
    fn from_str(text: &str) -> Result<Self, FrameError> {
        let bad = |expected| FrameError::Text { text: text.to_owned(), expected };
        let (id, data) = text.split_once('#').ok_or(bad("id#data"))?;
        let number = hex(id).ok_or(bad("an identifier of 3 or 8 hex digits"))?;
        let word = match id.len() {
            3 if number <= 0x7FF => number,
            8 if number & 0x2000_0000 != 0 => number & 0x3FFF_FFFF,
            8 if number <= 0x1FFF_FFFF => 0x8000_0000 | number,
            _ => return Err(bad("an identifier of 3 hex digits up to 7FF, or of 8")),
        };
        if let Some(len) = data.strip_prefix(['R', 'r']) {
            let len = if len.is_empty() { 0 } else { len.parse().map_err(|_| bad("a length after R"))? };
            return Frame::remote_from_word(word, len);
        }
        let digits: String = data.chars().filter(|c| *c != '.').collect();
        if !digits.is_ascii() || !digits.len().is_multiple_of(2) {
            return Err(bad("two hex digits per byte"));
        }
        let bytes: Option<Vec<u8>> =
            digits.as_bytes().chunks(2).map(|pair| hex(std::str::from_utf8(pair).ok()?).map(|b| b as u8)).collect();
        Frame::from_word(word, &bytes.ok_or(bad("two hex digits per byte"))?)
    }
}

/// Hex digits and nothing else: `from_str_radix` alone would take a sign.
fn hex(digits: &str) -> Option<u32> {
    digits.bytes().all(|b| b.is_ascii_hexdigit()).then(|| u32::from_str_radix(digits, 16).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn log_lines_are_those_of_candump() {
        let frame: Frame = "181#0102".parse().unwrap();
        let line = log_line(Duration::new(1_436_509_052, 249_713_000), "vcan0", &frame);
        assert_eq!(line, "(1436509052.249713) vcan0 181#0102");
        assert_eq!(parse_log_line(&line), Ok((Duration::new(1_436_509_052, 249_713_000), "vcan0".into(), frame)));
    }

    #[test]
    fn every_kind_has_its_text() {
        for text in ["000#0100", "701#R", "701#R1", "00000181#07", "20000040#0000000000000000", "080#"] {
            assert_eq!(text.parse::<Frame>().unwrap().to_string(), text);
        }
        assert_eq!("181#01.02".parse::<Frame>().unwrap().to_string(), "181#0102");
    }

    #[test]
    fn bad_text_says_what_was_expected() {
        for text in ["", "181", "18#00", "800#00", "181#0", "181#0g", "+81#00", "181#000102030405060708", "181#é"] {
            assert!(text.parse::<Frame>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_recorder_writes_lines_and_counts_what_it_loses() {
        struct DiskFull;
        impl Write for DiskFull {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::Error::other("disk full"))
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut recorder = CandumpWriter::new("vcan0", Box::new(DiskFull));
        recorder.record(Duration::ZERO, &Frame::data_frame(0x181, &[]).unwrap());
        assert_eq!(recorder.lost(), 1);
    }

    proptest! {
        #[test]
        fn text_round_trips(bytes in any::<[u8; 16]>()) {
            if let Ok(frame) = Frame::from_bytes(&bytes) {
                let text = frame.to_string();
                let again: Frame = text.parse().unwrap();
                prop_assert_eq!(again.to_string(), text);
            }
        }

        #[test]
        fn any_text_is_a_frame_or_an_error(text in ".{0,24}") {
            let _ = text.parse::<Frame>();
            let _ = parse_log_line(&text);
        }
    }
}
