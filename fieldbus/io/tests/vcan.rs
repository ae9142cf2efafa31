//! The same bus on real CAN sockets: runs where the kernel has an interface `vcan0`, and says so where it has not.
//!
//! `vcan_uml.sh` next to this file runs it inside a user-mode Linux, on machines whose own kernel has no CAN.

#[path = "../../protocol/tests/crowd/mod.rs"]
mod crowd;
#[path = "vcan/load.rs"]
mod load;

use std::io::Write;
use std::sync::{Arc, Mutex, Once};
use std::time::{Duration, Instant};

use embedded_can::{ExtendedId, Frame as _, StandardId};
use linewright_canopen::candump::{CandumpWriter, parse_log_line};
use linewright_canopen::{BusEvent, CanopenMessage, Frame, FrameKind, Manager, NodeId};
use linewright_fieldbus::bus::Transport;
use linewright_fieldbus::{Bus, BusOptions, Clock, Driver};
use linewright_line::{Device, DeviceBus as BusName, DeviceKind, InputId, OutputId, Owner, Timing};

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

/// Tests share the one interface: one at a time, so that none hears another's frames.
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
        let owner = Owner::Console;
        let description = Device {
            name: "io".to_owned(),
            owner,
            bus: BusName::Line,
            kind: DeviceKind::io(4, vec![Some(InputId(0))], vec![Some(OutputId(0))]),
        };
        let manager = Manager::new([&description], Timing::default()).unwrap();
        let mut driver = Driver::new(bus, manager, Clock::start());
        // A device in its simplest form: it takes every setting, and reports its output as its input.
        let plays_device = async {
            device.send(&"704#00".parse().unwrap());
            loop {
                let frame = device.recv().await.expect("the interface is there");
                let answer = match frame.data() {
                    // What lets its output go is as it was told.
                    [0x40, 0x29, 0x10, 1, ..] => Frame::data_frame(0x584, &[0x4F, 0x29, 0x10, 1, 0, 0, 0, 0]),
                    [0x40, 0x06, 0x62, 1, ..] => Frame::data_frame(0x584, &[0x4F, 0x06, 0x62, 1, 0xFF, 0, 0, 0]),
                    [0x40, 0x07, 0x62, 1, ..] => Frame::data_frame(0x584, &[0x4F, 0x07, 0x62, 1, 0, 0, 0, 0]),
                    // Whatever else is read is a number of four bytes.
                    [0x40, low, high, sub, ..] if frame.cob_id() == Some(0x604) => {
                        Frame::data_frame(0x584, &[0x43, *low, *high, *sub, 0x91, 0x01, 0x03, 0])
                    }
                    [0x23 | 0x2B | 0x2F, low, high, sub, ..] if frame.cob_id() == Some(0x604) => {
                        Frame::data_frame(0x584, &[0x60, *low, *high, *sub, 0, 0, 0, 0])
                    }
                    [0x01, 0x04] if frame.cob_id() == Some(0) => Frame::data_frame(0x184, &[0]),
                    [bits] if frame.cob_id() == Some(0x204) => Frame::data_frame(0x184, &[*bits]),
                    _ => None,
                };
                if let Some(answer) = answer {
                    device.send(&answer);
                }
            }
        };
        let drives = async {
            let node = NodeId::new(4).unwrap();
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
        assert!(frames.iter().any(|f| f.to_string() == "204#01"), "{log}");
        assert!(frames.iter().all(|f| CanopenMessage::decode(f).is_ok()), "{log}");
    });
}

/// Not a limit but a figure, printed with `--nocapture`: a frame there and back between two threads.
#[test]
fn round_trip() {
    let _alone = alone();
    run(async {
        let Some(mut bus) = open() else { return };
        std::thread::spawn(|| {
            run(async {
                let Some(mut echo) = open() else { return };
                loop {
                    let frame = echo.recv().await.expect("the interface is there");
                    if frame.cob_id() == Some(0x100) {
                        return;
                    }
                    echo.send(&frame);
                }
            });
        });
        let mut times = Vec::new();
        for number in 0..1000u16 {
            let frame = Frame::data_frame(0x181, &number.to_le_bytes()).unwrap();
            let sent = Instant::now();
            loop {
                bus.send(&frame);
                if let Ok(heard) = tokio::time::timeout(Duration::from_millis(200), bus.recv()).await {
                    assert_eq!(heard.expect("the interface is there"), frame);
                    break;
                }
            }
            times.push(sent.elapsed());
        }
        bus.send(&Frame::data_frame(0x100, &[]).unwrap());
        times.sort();
        println!("round trip: median {:?}, 99 % below {:?}", times[times.len() / 2], times[times.len() * 99 / 100]);
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
