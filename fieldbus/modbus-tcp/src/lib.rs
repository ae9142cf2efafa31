//! Modbus TCP devices of a node: the manager of `linewright_modbus` at work, over connections of `tokio-modbus`.
//!
//! Each connection is a task: it is made, sends one request at a time and brings the answers. Its work, and when an
//! answer is too late, are decided by the manager.
//!
//! A last order (outputs off) does not wait for an answer under way: it is written to the connection's socket by itself.

mod last;
mod link;
mod texts;

use linewright_fieldbus::Clock;
use linewright_fieldbus_seam::{
    Answer, BusRequest, BusTarget, Diagnosis, Fieldbus, InputImage, LastOrders, News, NextNews,
};
use linewright_line::{Device, Owner};
use linewright_modbus::{LinkAct, LinkOutcome, LinkTask, ModbusManager, ModbusOutbox};
use tokio::sync::mpsc;

pub use last::{LastOrder, LastOutcome, send_all};
use link::Connection;

/// Outcome from a connection: place of the device, number of the connection, outcome.
type Brought = (usize, u32, LinkOutcome);

/// The Modbus devices of a node, with their manager at work.
pub struct ModbusTcp {
    manager: ModbusManager,
    clock: Clock,
    out: ModbusOutbox,
    /// Of each device, its connection.
    links: Vec<Option<Connection>>,
    lasts: Vec<LastOrder>,
    to: mpsc::UnboundedSender<Brought>,
    from: mpsc::UnboundedReceiver<Brought>,
}

impl ModbusTcp {
    /// The bus of the Modbus devices among these. Nothing is connected before [`Fieldbus::next`] is called, within a
    /// tokio runtime.
    pub fn new<'a>(devices: impl IntoIterator<Item = &'a Device>, clock: Clock) -> Self {
        let manager = ModbusManager::new(devices);
        let addresses = manager.addresses().map(|(address, unit, _)| (address, unit));
        let lasts = addresses.zip(manager.last_requests()).map(|(at, request)| LastOrder::new(at, request));
        let lasts: Vec<LastOrder> = lasts.collect();
        let (to, from) = mpsc::unbounded_channel();
        let links = lasts.iter().map(|_| None).collect();
        ModbusTcp { manager, clock, out: ModbusOutbox::default(), links, lasts, to, from }
    }

    /// Has the connections do what they have to.
    fn flush(&mut self) {
        for LinkAct { device, link, what } in self.out.acts.drain(..) {
            match what {
                LinkTask::Connect => {
                    let place = self.manager.addresses().nth(device);
                    let Some((address, unit, timeout)) = place else { continue };
                    let (last, to) = (self.lasts[device].clone(), self.to.clone());
                    self.links[device] = Some(Connection::open((address, unit, timeout), last, (device, link), to));
                }
                LinkTask::Ask(request) => {
                    if let Some(link) = &self.links[device] {
                        link.ask(request);
                    }
                }
                LinkTask::Close { last } => {
                    if last.is_some() {
                        self.lasts[device].send();
                    }
                    self.links[device] = None;
                    self.lasts[device].forget();
                }
            }
        }
    }
}

impl Fieldbus for ModbusTcp {
    fn describe(&self) -> String {
        let mut addresses: Vec<&str> = self.manager.addresses().map(|(address, ..)| address).collect();
        addresses.dedup();
        format!("Modbus TCP {}", addresses.join(", "))
    }

    fn next(&mut self) -> NextNews<'_> {
        Box::pin(async move {
            loop {
                let now = self.clock.now();
                if self.manager.next_deadline() <= now {
                    self.manager.poll(now, &mut self.out);
                }
                self.flush();
                if !self.out.news.is_empty() {
                    return Ok(std::mem::take(&mut self.out.news));
                }
                tokio::select! {
                    biased;
                    // The sender is this one's own: it never ends.
                    Some((device, link, outcome)) = self.from.recv() => {
                        self.manager.handle(self.clock.now(), device, link, outcome, &mut self.out);
                    }
                    () = self.clock.sleep_until(Some(self.manager.next_deadline())) => {}
                }
            }
        })
    }

    fn inputs(&self, owner: Owner) -> Option<InputImage> {
        self.manager.inputs(self.clock.now(), owner)
    }

    fn set_outputs(&mut self, owner: Owner, image: u128) {
        self.manager.set_outputs(self.clock.now(), owner, image, &mut self.out);
        self.flush();
    }

    fn release_outputs(&mut self) {
        self.manager.release_outputs(&mut ModbusOutbox::default());
        // The answers are not read any more then.
        self.links.iter_mut().for_each(|link| *link = None);
        send_all(&self.lasts);
        self.lasts.iter().for_each(LastOrder::forget);
    }

    fn last_orders(&self) -> LastOrders {
        let lasts = self.lasts.clone();
        Box::new(move || _ = send_all(&lasts))
    }

    fn trouble(&self, owner: Owner) -> Vec<String> {
        self.manager.trouble(self.clock.now(), owner)
    }

    fn diagnoses(&self) -> Vec<Diagnosis> {
        self.manager.diagnoses(self.clock.now())
    }

    fn states(&self, take: &mut dyn FnMut(&str, &'static str)) {
        self.manager.states().for_each(|(name, state)| take(name, state));
    }

    fn ask(&mut self, target: &BusTarget, request: BusRequest) -> Option<u64> {
        let number = self.manager.ask(self.clock.now(), target, request, &mut self.out);
        self.flush();
        number
    }

    fn take_answers(&mut self) -> Vec<(u64, Answer)> {
        // Answered at once: the caller takes the answer, and need not be woken for it.
        self.out.news.retain(|news| *news != News::Answered);
        std::mem::take(&mut self.out.answers)
    }
}
