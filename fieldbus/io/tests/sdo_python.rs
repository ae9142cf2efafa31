//! Our SDO client and server against the Python package `canopen`, over a real CAN interface.
//!
//! Runs where the kernel has an interface `vcan0` and `LINEWRIGHT_PYTHON` names a Python that has `canopen`; elsewhere
//! it is skipped with a message. `vcan_uml.sh` next to this file runs it in a user-mode Linux where the kernel has no
//! CAN.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

use linewright_canopen::sdo::{Abort, Dictionary, ObjectId, SdoServer, TransferFailure, TransferMode, TransferOptions};
use linewright_canopen::{CanopenMessage, NodeId};
use linewright_fieldbus::bus::Transport;
use linewright_fieldbus::{Bus, BusOptions, Clock, sdo_client};
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use tokio::sync::Notify;

const INTERFACE: &str = "vcan0";
const LENGTHS: [usize; 17] = [1, 2, 3, 4, 5, 7, 8, 14, 20, 63, 64, 65, 127, 500, 889, 890, 2000];

const DOMAIN: ObjectId = ObjectId::new(0x2000, 0);
const CONSTANT: ObjectId = ObjectId::new(0x2001, 0);
const NUMBER: ObjectId = ObjectId::new(0x2002, 0);

/// A bus and a Python, or `None`, visibly.
fn equipment() -> Option<(Bus, String)> {
    let bus = Bus::open(INTERFACE, &BusOptions { transport: Transport::SocketCan, dir: None });
    let python = std::env::var("LINEWRIGHT_PYTHON").map_err(|_| "LINEWRIGHT_PYTHON names no Python with `canopen`");
    let missing = match (bus, python) {
        (Ok(bus), Ok(python)) => return Some((bus, python)),
        (Err(error), _) => error.to_string(),
        (_, Err(error)) => error.to_owned(),
    };
    static SAID: Once = Once::new();
    let text = format!("SKIPPED tests/sdo_python.rs, nothing tested: {missing}. See docs/can.md.\n");
    SAID.call_once(|| _ = std::io::stderr().write_all(text.as_bytes()));
    None
}

fn python(python: &str, role: &str, node: NodeId) -> Child {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sdo_python.py");
    let mut command = Command::new(python);
    command.arg(script).args([role, INTERFACE, &node.get().to_string()]);
    // Interpreter and script are read only here: nothing is left beside them.
    command.env("PYTHONDONTWRITEBYTECODE", "1").kill_on_drop(true);
    if role == "server" {
        command.stdout(Stdio::piped());
    }
    command.spawn().expect("Python starts")
}

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(Duration::from_secs(100), test).await.expect("an end within 100 s") })
}

fn is_refused(error: &sdo_client::SdoError, code: Abort) -> bool {
    matches!(error, sdo_client::SdoError::Transfer { error, .. } if error.cause == TransferFailure::Refused(code))
}

fn pattern(len: usize) -> Vec<u8> {
    (0..len).map(|at| (at * 7 + at / 251) as u8).collect()
}

struct Store(BTreeMap<ObjectId, Vec<u8>>);

impl Dictionary for Store {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        self.0.get(&object).map(|data| Cow::Borrowed(&**data)).ok_or(Abort::NO_OBJECT)
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        self.may_write(object, Some(data.len()))?;
        self.0.insert(object, data.to_vec());
        Ok(())
    }

    fn may_write(&mut self, object: ObjectId, len: Option<usize>) -> Result<(), Abort> {
        match object {
            DOMAIN => Ok(()),
            NUMBER if len.is_none_or(|len| len == 4) => Ok(()),
            NUMBER => Err(Abort::LENGTH),
            CONSTANT => Err(Abort::READ_ONLY),
            _ => Err(Abort::NO_OBJECT),
        }
    }
}

/// Is node `node` for ever.
async fn serve(mut bus: Bus, node: NodeId) {
    let mut store = Store(BTreeMap::from([(DOMAIN, vec![1]), (CONSTANT, vec![2]), (NUMBER, vec![0; 4])]));
    let (clock, mut server, mut out) = (Clock::start(), SdoServer::new(4096), Vec::new());
    loop {
        tokio::select! {
            biased;
            frame = bus.recv() => if let Ok(CanopenMessage::SdoRequest { node: asked, raw }) = CanopenMessage::decode(&frame.expect("the interface is there"))
                && asked == node
            {
                server.handle(clock.now(), &raw, &mut store, &mut out);
            },
            () = clock.sleep_until(server.next_deadline()) => {}
        }
        server.poll(clock.now(), &mut out);
        for raw in out.drain(..) {
            bus.send(&CanopenMessage::SdoResponse { node, raw }.encode());
        }
    }
}

#[test]
fn python_reads_and_writes_our_server() {
    run(async {
        let Some((bus, interpreter)) = equipment() else { return };
        let node = NodeId::new(5).unwrap();
        let mut client = python(&interpreter, "client", node);
        tokio::select! {
            () = serve(bus, node) => unreachable!("it serves for ever"),
            ended = client.wait() => assert!(ended.unwrap().success(), "Python is not content, see above"),
        }
    });
}

#[test]
fn we_read_and_write_the_server_of_python() {
    run(async {
        let Some((mut bus, interpreter)) = equipment() else { return };
        let node = NodeId::new(6).unwrap();
        let mut server = python(&interpreter, "server", node);
        let mut lines = BufReader::new(server.stdout.take().unwrap()).lines();
        assert_eq!(lines.next_line().await.unwrap().as_deref(), Some("ready"));
        let options = |mode| TransferOptions { mode, ..TransferOptions::default() };
        assert_eq!(sdo_client::read(&mut bus, node, DOMAIN, options(TransferMode::Auto)).await.unwrap(), b"initial");
        for len in LENGTHS {
            let data = pattern(len);
            // It has no blocks: a block download is refused, a block upload answered in segments.
            for mode in [TransferMode::Auto, TransferMode::Segmented, TransferMode::Block] {
                let started = Instant::now();
                sdo_client::write(&mut bus, node, DOMAIN, &data, options(mode)).await.unwrap();
                let written = started.elapsed();
                assert_eq!(
                    sdo_client::read(&mut bus, node, DOMAIN, options(mode)).await.unwrap(),
                    data,
                    "{len} {mode:?}"
                );
                if len == 2000 {
                    let read = started.elapsed() - written;
                    println!("ours: {len} bytes written in {written:.1?}, read in {read:.1?}, {mode:?}");
                }
            }
        }
        let constant = sdo_client::read(&mut bus, node, CONSTANT, TransferOptions::default()).await.unwrap();
        assert_eq!(constant, b"a constant of the other side");
        assert_eq!(
            sdo_client::read(&mut bus, node, NUMBER, TransferOptions::default()).await.unwrap(),
            7u32.to_le_bytes()
        );
        let missing = ObjectId::new(0x2FFF, 0);
        let error = sdo_client::read(&mut bus, node, missing, TransferOptions::default()).await.unwrap_err();
        assert!(is_refused(&error, Abort::NO_OBJECT), "{error}");
        let error = sdo_client::write(&mut bus, node, CONSTANT, &[1], TransferOptions::default()).await.unwrap_err();
        assert!(is_refused(&error, Abort::READ_ONLY), "{error}");
        let absent = NodeId::new(99).unwrap();
        let brief = TransferOptions { timeout: Duration::from_millis(20), ..TransferOptions::default() };
        let error = sdo_client::read(&mut bus, absent, NUMBER, brief).await.unwrap_err();
        assert_eq!(error.to_string(), "node 63h, object 2002h:00: no answer within 20 ms, asked 3 times");
    });
}

/// Both sides ours, for the figures: what a transfer of 2000 bytes takes.
#[test]
fn ours_with_ours() {
    run(async {
        let Some((mut bus, _)) = equipment() else { return };
        let node = NodeId::new(7).unwrap();
        // On a thread of its own, as two programs would be.
        let (ready, stop) = (Arc::new(Notify::new()), Arc::new(Notify::new()));
        let server = std::thread::spawn({
            let (ready, stop) = (ready.clone(), stop.clone());
            move || {
                run(async {
                    let Some((bus, _)) = equipment() else { return };
                    ready.notify_one();
                    tokio::select! {
                        () = serve(bus, node) => unreachable!("it serves for ever"),
                        () = stop.notified() => {}
                    }
                });
            }
        });
        ready.notified().await;
        let data = pattern(2000);
        for (mode, burst) in [(TransferMode::Segmented, 4), (TransferMode::Block, 4), (TransferMode::Block, 127)] {
            let options = TransferOptions { mode, burst, ..TransferOptions::default() };
            let started = Instant::now();
            sdo_client::write(&mut bus, node, DOMAIN, &data, options).await.unwrap();
            let written = started.elapsed();
            assert_eq!(sdo_client::read(&mut bus, node, DOMAIN, options).await.unwrap(), data);
            let read = started.elapsed() - written;
            println!(
                "ours with ours: 2000 bytes written in {written:.1?}, read in {read:.1?}, {mode:?}, burst {burst}"
            );
        }
        stop.notify_one();
        server.join().unwrap();
    });
}
