//! The same bus on real CAN sockets: runs where the kernel has an interface `vcan0`, else skips with a message.
//!
//! `vcan_uml.sh` next to this file runs it inside a user-mode Linux, on machines whose own kernel has no CAN.

#[path = "vcan/load.rs"]
mod load;

use std::io::Write;
use std::sync::{Arc, Mutex, Once};
use std::time::Duration;

use embedded_can::{ExtendedId, Frame as _, StandardId};
use linewright_canopen::candump::{CandumpWriter, parse_log_line};
use linewright_canopen::{BusEvent, CanopenMessage, Frame, FrameKind, Manager};
use linewright_fieldbus::bus::Transport;
use linewright_fieldbus::{Bus, BusOptions, Clock, Driver};
use linewright_line::Timing;
use linewright_testkit::crowd;

const INTERFACE: &str = "vcan0";

/// A bus on the interface, or `None`, visibly, where there is none.
fn open() -> Option<Bus> {
    let options = BusOptions { transport: Transport::SocketCan, dir: None };
    match Bus::open(INTERFACE, &options) {
        Ok(bus) => Some(bus),
        Err(error) => {
            static SAID: Once = Once::new();
            let text =
                format!("SKIPPED tests/vcan.rs, nothing tested: {error}. See docs/can.md for how to get vcan0.\n");
            SAID.call_once(|| say(&text));
            None
        }
    }
}

/// Past the test harness, which would swallow what a passing test prints.
fn say(text: &str) {
    _ = std::io::stderr().write_all(text.as_bytes());
}

/// Tests share the one interface: one at a time, so that none receives another's frames.
fn alone() -> std::sync::MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(Duration::from_secs(20), test).await.expect("nothing within 20 s") })
}

#[test]
fn every_kind_of_frame_crosses_and_none_comes_back() {
    let _alone = alone();
    run(async {
        let (Some(mut a), Some(mut b)) = (open(), open()) else { return };
        assert_eq!(a.describe(), "SocketCAN vcan0");
        let frames = [
            Frame::data_frame(0x181, &[1, 2]).unwrap(),
            Frame::data_frame(0x000, &[]).unwrap(),
            Frame::new(ExtendedId::new(0x181).unwrap(), &[7; 8]).unwrap(),
            Frame::new_remote(StandardId::new(0x701).unwrap(), 1).unwrap(),
        ];
        for frame in &frames {
            a.send(frame);
        }
        for frame in frames {
            let heard = b.recv().await.expect("the interface is there");
            assert_eq!((heard, heard.kind() == FrameKind::Remote), (frame, frame.is_remote_frame()));
        }
        assert!(tokio::time::timeout(Duration::from_millis(50), a.recv()).await.is_err(), "own frames are not heard");
        assert_eq!((a.stats().sent, a.stats().send_errors, b.stats().received), (4, 0, 4));
    });
}

#[test]
fn a_manager_brings_a_device_up_and_the_log_can_be_read() {
    let _alone = alone();
    run(async {
        let (Some(bus), Some(mut device)) = (open(), open()) else { return };
        let log = Log::default();
        device.record(CandumpWriter::new(INTERFACE, Box::new(log.clone())));
        let owner = crowd::owner(1);
        let manager = Manager::new(&crowd::devices(1), Timing::default()).unwrap();
        let mut driver = Driver::new(bus, manager, Clock::start());
        // A device in its simplest form: it takes every setting, and reports its output as its input.
        let plays_device = async {
            device.send(&crowd::heartbeat(1));
            loop {
                let frame = device.recv().await.expect("the interface is there");
                let answer = match CanopenMessage::decode(&frame) {
                    Ok(CanopenMessage::Rpdo1 { payload, .. }) => Some(crowd::inputs(1, payload.bits())),
                    _ => crowd::answer(&frame),
                };
                if let Some(answer) = answer {
                    device.send(&answer);
                }
            }
        };
        let drives = async {
            let node = crowd::node(1);
            while !driver.next().await.expect("nobody else is there").contains(&BusEvent::DeviceUp { node }) {}
            driver.set_outputs(owner, 1);
            while driver.inputs(owner).bits != 1 {
                driver.next().await.expect("nobody else is there");
            }
        };
        tokio::select! {
            () = plays_device => unreachable!("it plays for ever"),
            () = drives => {}
        }
        let log = String::from_utf8(log.0.lock().unwrap().clone()).unwrap();
        print!("{log}");
        let frames: Vec<Frame> = log.lines().map(|line| parse_log_line(line).unwrap().2).collect();
        assert!(frames.iter().any(|f| f.to_string() == "201#0100"), "{log}");
        assert!(frames.iter().all(|f| CanopenMessage::decode(f).is_ok()), "{log}");
    });
}

#[derive(Clone, Default)]
struct Log(Arc<Mutex<Vec<u8>>>);

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
