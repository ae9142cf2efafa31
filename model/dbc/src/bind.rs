//! What a description says in the names of a DBC file → numbers, with every problem at its place in the description.

use linewright_line::{
    Checksum, Field, FrameBinding, Frames, HeardFrame, Named, Page, Problem, Receive, Send, ToldFrame, When, suggestion,
};

use crate::{Database, Message, Mux, Signal};

/// Bytes of a classic frame.
const LEN_MAX: u64 = 8;
/// A counter of fewer bits comes round too soon to show that a frame is new.
const COUNTER_BITS_MIN: u8 = 2;

/// Works out what `frames` means by `database`: all problems at once, each pointing into the description.
pub fn bind(frames: &Frames, database: &Database) -> Result<FrameBinding, Vec<Problem>> {
    let mut binder = Binder { database, file: &frames.file.name, problems: Vec::new() };
    let heard: Vec<_> = frames.receive.iter().filter_map(|receive| binder.heard(receive)).collect();
    let told: Vec<_> = frames.send.iter().filter_map(|send| binder.told(send)).collect();
    binder.heard_once(&frames.receive);
    if binder.problems.is_empty() { Ok(FrameBinding { heard, told }) } else { Err(binder.problems) }
}

struct Binder<'a> {
    database: &'a Database,
    file: &'a str,
    problems: Vec<Problem>,
}

impl<'a> Binder<'a> {
    fn problem(&mut self, at: &Named, message: String, hint: Option<String>) {
        self.problems.push(Problem {
            message,
            span: at.at.clone(),
            line: 1,
            column: 1,
            hint,
            label: None,
            also: Vec::new(),
            is_warning: false,
        });
    }

    fn message(&mut self, named: &Named) -> Option<&'a Message> {
        let database = self.database;
        let Some(message) = database.messages.iter().find(|message| message.name == named.name) else {
            let hint = suggestion(&named.name, database.messages.iter().map(|message| message.name.as_str()));
            self.problem(named, format!("{} has no message `{}`", self.file, named.name), hint);
            return None;
        };
        if message.len > LEN_MAX {
            self.problem(named, format!("{message} is no classic frame: that has {LEN_MAX} bytes"), None);
            return None;
        }
        Some(message)
    }

    fn signal(&mut self, message: &'a Message, named: &Named) -> Option<(&'a Signal, Field)> {
        let Some(signal) = message.signals.iter().find(|signal| signal.name == named.name) else {
            let names = message.signals.iter().map(|signal| signal.name.as_str());
            let near = suggestion(&named.name, names.clone());
            let hint = near.or_else(|| Some(format!("it has {}", names.collect::<Vec<_>>().join(", "))));
            self.problem(named, format!("message `{}` has no signal `{}`", message.name, named.name), hint);
            return None;
        };
        let len = message.len as u8;
        let Some(field) = signal.field.filter(|field| field.fits(len)) else {
            let what = format!("signal `{}` does not lie within {message}", signal.name);
            self.problem(named, what, Some(format!("its definition in {} is wrong", self.file)));
            return None;
        };
        Some((signal, field))
    }

    /// A signal that is in every frame.
    fn plain(&mut self, message: &'a Message, named: &Named, what: &str) -> Option<Field> {
        let (signal, field) = self.signal(message, named)?;
        if matches!(signal.mux, Mux::Selected(_) | Mux::Nested) {
            self.problem(named, format!("`{}` is not in every frame, as {what} must be", signal.name), None);
            return None;
        }
        Some(field)
    }

    fn counter(&mut self, message: &'a Message, named: Option<&Named>) -> Option<Option<Field>> {
        let Some(named) = named else { return Some(None) };
        let field = self.plain(message, named, "a counter")?;
        if field.size < COUNTER_BITS_MIN {
            self.problem(named, format!("`{}` has one bit, too few to count with", named.name), None);
            return None;
        }
        Some(Some(field))
    }

    fn checksum(&mut self, message: &'a Message, named: Option<&(Named, Checksum)>) -> Option<Option<(u8, Checksum)>> {
        let Some((named, kind)) = named else { return Some(None) };
        let field = self.plain(message, named, "a checksum")?;
        let whole = field.size == 8 && field.start % 8 == if field.motorola { 7 } else { 0 };
        if !whole {
            let hint = Some("such checksums are kept in one whole byte".to_owned());
            self.problem(named, format!("`{}` is not one whole byte", named.name), hint);
            return None;
        }
        Some(Some((field.start / 8, *kind)))
    }

    fn selector(&mut self, message: &'a Message, named: &Named) -> Option<Field> {
        let selector =
            message.signals.iter().find(|signal| signal.mux == Mux::Selector).and_then(|signal| signal.field);
        let selector = selector.filter(|field| field.fits(message.len as u8));
        if selector.is_none() {
            self.problem(
                named,
                format!("message `{}` has no usable selector for `{}`", message.name, named.name),
                None,
            );
        }
        selector
    }

    fn heard(&mut self, receive: &Receive) -> Option<HeardFrame> {
        let message = self.message(&receive.message)?;
        let counter = self.counter(message, receive.counter.as_ref());
        let checksum = self.checksum(message, receive.checksum.as_ref());
        let mut pages: Vec<Page> = Vec::new();
        for input in &receive.inputs {
            let Some((signal, field)) = self.signal(message, &input.signal) else { continue };
            let selected = match &signal.mux {
                Mux::Plain | Mux::Selector => None,
                Mux::Selected(values) => match self.selector(message, &input.signal) {
                    Some(selector) => Some((selector, values.clone())),
                    None => continue,
                },
                Mux::Nested => {
                    let what = format!("`{}` is multiplexed by a signal that is multiplexed itself", signal.name);
                    self.problem(&input.signal, what, Some("one selector in a message is supported".to_owned()));
                    continue;
                }
            };
            self.condition_is_possible(&input.signal, signal, &field, input.when);
            let entry = (input.input, field, input.when);
            match pages.iter_mut().find(|page| page.selected == selected) {
                Some(page) => page.inputs.push(entry),
                None => pages.push(Page { selected, inputs: vec![entry] }),
            }
        }
        if pages.is_empty() {
            pages.push(Page { selected: None, inputs: Vec::new() });
        }
        Some(HeardFrame {
            name: message.name.clone(),
            id: message.id,
            len: message.len as u8,
            timeout: receive.timeout,
            counter: counter?,
            checksum: checksum?,
            pages,
        })
    }

    fn condition_is_possible(&mut self, at: &Named, signal: &Signal, field: &Field, when: When) {
        match when {
            When::Bit(bit) if bit >= field.size => {
                self.problem(at, format!("`{}` has {} bits, and no bit {bit}", signal.name, field.size), None);
            }
            When::Equals(value) => {
                let nearest = field.bits(value).map(|bits| field.value(bits));
                let step = field.factor.abs() * 1e-6;
                if nearest.is_none_or(|nearest| (nearest - value).abs() > step) {
                    let hint = nearest.map(|nearest| format!("the nearest value is {nearest}"));
                    let what = format!("`{}` is never {value} {}", signal.name, signal.unit);
                    self.problem(at, what.trim_end().to_owned(), hint);
                }
            }
            _ => {}
        }
    }

    /// A message is listed once: its timeout and its counter are its own.
    fn heard_once(&mut self, receive: &[Receive]) {
        for (nth, this) in receive.iter().enumerate() {
            if receive[..nth].iter().any(|earlier| earlier.message.name == this.message.name) {
                let what = format!("message `{}` is received twice", this.message.name);
                self.problem(&this.message, what, Some("put all its inputs into one entry".to_owned()));
            }
        }
    }

    fn told(&mut self, send: &Send) -> Option<ToldFrame> {
        let message = self.message(&send.message)?;
        let counter = self.counter(message, send.counter.as_ref());
        let checksum = self.checksum(message, send.checksum.as_ref());
        let mut rest = [0; 8];
        let mut used: Vec<&str> = send.counter.iter().map(|named| named.name.as_str()).collect();
        used.extend(send.checksum.iter().map(|(named, _)| named.name.as_str()));
        let mut selected: Vec<(&Named, &Signal)> = Vec::new();
        let once = |this: &mut Self, named: &Named| {
            if message.signals.iter().any(|signal| signal.name == named.name && used.contains(&signal.name.as_str())) {
                this.problem(named, format!("`{}` is given two values", named.name), None);
            }
        };
        for (named, value) in &send.set {
            once(self, named);
            let Some((signal, field)) = self.signal(message, named) else { continue };
            selected.push((named, signal));
            if let Some(bits) = self.bits(named, signal, &field, *value) {
                field.put(&mut rest, bits);
            }
        }
        used_twice(self, send);
        let mut outputs = Vec::new();
        for output in &send.outputs {
            once(self, &output.signal);
            let Some((signal, field)) = self.signal(message, &output.signal) else { continue };
            selected.push((&output.signal, signal));
            let off = self.bits(&output.signal, signal, &field, output.off);
            let on = self.bits(&output.signal, signal, &field, output.on);
            if let (Some(off), Some(on)) = (off, on) {
                if off == on {
                    let what = format!("`{}` is the same for {} and {}", signal.name, output.on, output.off);
                    self.problem(&output.signal, what, Some(format!("a step of it is {}", field.factor)));
                }
                field.put(&mut rest, off);
                outputs.push((output.output, field, on));
            }
        }
        for (named, signal) in selected {
            self.is_selected(message, named, signal, &rest);
        }
        let (name, id, len) = (message.name.clone(), message.id, message.len as u8);
        Some(ToldFrame { name, id, len, every: send.every, counter: counter?, checksum: checksum?, rest, outputs })
    }

    /// A signal that is multiplexed is sent with the selector's value that shows it.
    fn is_selected(&mut self, message: &'a Message, named: &Named, signal: &Signal, rest: &[u8; 8]) {
        match &signal.mux {
            Mux::Plain | Mux::Selector => {}
            Mux::Nested => {
                let what = format!("`{}` is multiplexed by a signal that is multiplexed itself", signal.name);
                self.problem(named, what, Some("one selector in a message is supported".to_owned()));
            }
            Mux::Selected(values) => {
                let Some(selector) = self.selector(message, named) else { return };
                let value = selector.get(rest);
                if !values.iter().any(|(first, last)| (*first..=*last).contains(&value)) {
                    let name = message.signals.iter().find(|signal| signal.mux == Mux::Selector);
                    let name = name.map_or("?", |selector| selector.name.as_str());
                    let shows = values.first().map_or(0, |(first, _)| *first);
                    let value = selector.value(shows);
                    let hint = format!("`set = [{{ signal = \"{name}\", value = {value} }}]`");
                    self.problem(named, format!("`{}` is not in the frame that is sent", signal.name), Some(hint));
                }
            }
        }
    }

    fn bits(&mut self, named: &Named, signal: &Signal, field: &Field, value: f64) -> Option<u64> {
        let bits = field.bits(value);
        if bits.is_none() {
            let what = format!("`{}` cannot be {value} {}", signal.name, signal.unit);
            self.problem(named, what.trim_end().to_owned(), Some(format!("it has {} bits", field.size)));
        }
        bits
    }
}

/// Each signal of a message that is sent follows one output, or has one value.
fn used_twice(binder: &mut Binder<'_>, send: &Send) {
    let set = send.set.iter().map(|(named, _)| named);
    let all: Vec<&Named> = set.chain(send.outputs.iter().map(|output| &output.signal)).collect();
    for (nth, named) in all.iter().enumerate() {
        if all[..nth].iter().any(|earlier| earlier.name == named.name) {
            binder.problem(named, format!("`{}` is given two values", named.name), None);
        }
    }
}
