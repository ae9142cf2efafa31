//! Service data: small reads, and an object of 10 kB there and back. The server is ours, on a thread of its own, and the
//! same for Python.

use std::borrow::Cow;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use linewright_canopen::sdo::{Abort, Dictionary, ObjectId, SdoServer, TransferMode, TransferOptions};
use linewright_canopen::{CanopenMessage, NodeId};
use linewright_fieldbus::{Bus, Clock, sdo_client};
use tokio::sync::Notify;

use super::{Place, block_on, of, python};

const NODE: u8 = 100;
const NUMBER: ObjectId = ObjectId::new(0x2002, 0);
const DOMAIN: ObjectId = ObjectId::new(0x2000, 0);
const LEN: usize = 10_000;
const READS: usize = 300;
const REPEATS: usize = 3;

struct Store {
    domain: Vec<u8>,
}

impl Dictionary for Store {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        match object {
            NUMBER => Ok(Cow::Borrowed(&[1, 2, 3, 4])),
            DOMAIN => Ok(Cow::Borrowed(&self.domain)),
            _ => Err(Abort::NO_OBJECT),
        }
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        self.may_write(object, Some(data.len()))?;
        self.domain = data.to_vec();
        Ok(())
    }

    fn may_write(&mut self, object: ObjectId, _: Option<usize>) -> Result<(), Abort> {
        if object == DOMAIN { Ok(()) } else { Err(Abort::NO_OBJECT) }
    }
}

fn node() -> NodeId {
    NodeId::new(NODE).expect("a node id")
}

/// Is the node until it is cancelled.
async fn serve(place: &Place) {
    let mut bus = Bus::open(place.interface, &place.options).expect("the bus is there");
    let (clock, mut server, mut out) = (Clock::start(), SdoServer::new(1 << 17), Vec::new());
    let mut store = Store { domain: vec![0; LEN] };
    loop {
        tokio::select! {
            biased;
            frame = bus.recv() => if let Ok(CanopenMessage::SdoRequest { node: asked, raw }) = CanopenMessage::decode(&frame.expect("the bus is there"))
                && asked == node()
            {
                server.handle(clock.now(), &raw, &mut store, &mut out);
            },
            () = clock.sleep_until(server.next_deadline()) => {}
        }
        server.poll(clock.now(), &mut out);
        for raw in out.drain(..) {
            bus.send(&CanopenMessage::SdoResponse { node: node(), raw }.encode());
        }
    }
}

pub fn run(place: &Place) {
    let stop = Arc::new(Notify::new());
    let server = thread::spawn({
        let (place, stop) = (place.clone(), stop.clone());
        move || {
            block_on(async {
                tokio::select! {
                    () = serve(&place) => {}
                    () = stop.notified() => {}
                }
            });
        }
    });
    thread::sleep(Duration::from_millis(100));
    block_on(ours(place));
    for _ in 0..REPEATS {
        python(place, &["sdo", &NODE.to_string()]);
    }
    stop.notify_one();
    server.join().expect("the server ends");
}

async fn ours(place: &Place) {
    let mut bus = Bus::open(place.interface, &place.options).expect("the bus is there");
    let mut reads = Vec::new();
    for _ in 0..READS {
        let began = Instant::now();
        sdo_client::read(&mut bus, node(), NUMBER, TransferOptions::default()).await.expect("it is read");
        reads.push(began.elapsed());
    }
    println!("  ours: a number read: {}", of(&mut reads));
    let data: Vec<u8> = (0..LEN).map(|at| (at * 7 + at / 251) as u8).collect();
    for (name, mode, burst) in [
        ("segments", TransferMode::Segmented, 4),
        ("blocks, 4 frames a ms", TransferMode::Block, 4),
        ("blocks, unpaced", TransferMode::Block, 127),
    ] {
        let options = TransferOptions { mode, burst, ..TransferOptions::default() };
        let (mut written, mut read) = (Vec::new(), Vec::new());
        for _ in 0..REPEATS {
            let began = Instant::now();
            sdo_client::write(&mut bus, node(), DOMAIN, &data, options).await.expect("it is written");
            written.push(began.elapsed());
            let began = Instant::now();
            assert_eq!(sdo_client::read(&mut bus, node(), DOMAIN, options).await.expect("it is read"), data);
            read.push(began.elapsed());
        }
        println!("  ours: {LEN} bytes in {name}: written {}; read {}", of(&mut written), of(&mut read));
    }
}
