//! The messages a device is sent: values for all that never changes, and places for outputs, counter and checksum.
//!
//! A message may be sent in several forms, with several values of its selector. To the device it is one message all the
//! same: it has one counter, which runs through all of its forms.

use linewright_line::{CyclicFrame, DbcName, FrameField, SentFrameBinding};

use crate::bind::Binder;
use crate::{DbcMessage, DbcSignal, Mux};

impl<'a> Binder<'a> {
    /// Bindings of all messages that the device is sent.
    pub(crate) fn all_told(&mut self, send: &[CyclicFrame]) -> Vec<SentFrameBinding> {
        let mut all: Vec<SentFrameBinding> = Vec::new();
        for send in send {
            let Some((message, told)) = self.told(send) else { continue };
            for earlier in all.iter().filter(|earlier| earlier.id == told.id) {
                self.forms_of_one_message(send, message, [earlier, &told]);
            }
            all.push(told);
        }
        all
    }

    fn forms_of_one_message(
        &mut self,
        send: &CyclicFrame,
        message: &DbcMessage,
        [earlier, told]: [&SentFrameBinding; 2],
    ) {
        let selector = message.selector();
        let shown = |told: &SentFrameBinding| selector.and_then(|(_, field)| shown(told, &field));
        if shown(told).is_none() || shown(told) == shown(earlier) {
            let one = "put all its signals into one entry";
            let hint = match selector {
                Some((selector, _)) => format!("{one}, or give `{}` another value in `set` of each", selector.name),
                None => one.to_owned(),
            };
            self.problem(&send.message, format!("message `{}` is sent twice", message.name), Some(hint));
        } else if (earlier.counter, earlier.checksum) != (told.counter, told.checksum) {
            let what = format!("message `{}` has another counter or checksum here than before", message.name);
            self.problem(
                &send.message,
                what,
                Some("to the device it is one message: the same in each entry".to_owned()),
            );
        }
    }

    fn told(&mut self, send: &CyclicFrame) -> Option<(&'a DbcMessage, SentFrameBinding)> {
        let message = self.message(&send.message)?;
        let counter = self.counter(message, send.counter.as_ref());
        let checksum = self.checksum(message, send.checksum.as_ref());
        let mut rest = [0; 8];
        let mut given: Vec<(&DbcName, &DbcSignal)> = Vec::new();
        for (named, value) in &send.set {
            let Some((signal, field)) = self.signal(message, named) else { continue };
            given.push((named, signal));
            if let Some(bits) = self.bits(named, signal, &field, *value) {
                field.put(&mut rest, bits);
            }
        }
        let mut outputs = Vec::new();
        for output in &send.outputs {
            let Some((signal, field)) = self.signal(message, &output.signal) else { continue };
            given.push((&output.signal, signal));
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
        for (named, signal) in &given {
            self.is_selected(message, named, signal, &rest);
        }
        self.signals_are_apart(message, send, given.iter().any(|(_, signal)| matches!(signal.mux, Mux::Selected(_))));
        let (name, id, len) = (message.name.clone(), message.id, message.len as u8);
        let (every, lets_go_after, counter, checksum) = (send.every, send.lets_go_after, counter?, checksum?);
        Some((message, SentFrameBinding { name, id, len, every, lets_go_after, counter, checksum, rest, outputs }))
    }

    /// A multiplexed signal is there because of the selector's value, which then is for nothing else.
    fn signals_are_apart(&mut self, message: &'a DbcMessage, send: &CyclicFrame, is_multiplexed: bool) {
        let checksum = send.checksum.iter().map(|(named, _)| named);
        let changing = || send.counter.iter().chain(checksum.clone()).chain(send.outputs.iter().map(|own| &own.signal));
        let set = send.set.iter().map(|(named, _)| named);
        let selector = message.selector().filter(|_| is_multiplexed).map(|(selector, _)| selector);
        if let Some((selector, named)) =
            selector.and_then(|own| Some((own, changing().find(|named| named.name == own.name)?)))
        {
            let what = format!("`{}` selects what is in the frame, and changes", selector.name);
            self.problem(named, what, Some("give it one value, in `set`".to_owned()));
            return;
        }
        // A signal that is not set is 0, and its bits are its own.
        let silent = selector.filter(|own| !set.clone().any(|named| named.name == own.name));
        self.apart(message, set.clone().chain(changing()), silent);
    }

    /// A signal that is multiplexed is sent with the selector's value that shows it.
    fn is_selected(&mut self, message: &'a DbcMessage, named: &DbcName, signal: &DbcSignal, rest: &[u8; 8]) {
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
                    let name = message.selector().map_or("?", |(selector, _)| selector.name.as_str());
                    let shows = values.first().map_or(0, |(first, _)| *first);
                    let value = selector.value(shows);
                    let hint = format!("`set = [{{ signal = \"{name}\", value = {value} }}]`");
                    self.problem(named, format!("`{}` is not in the frame that is sent", signal.name), Some(hint));
                }
            }
        }
    }

    fn bits(&mut self, named: &DbcName, signal: &DbcSignal, field: &FrameField, value: f64) -> Option<u64> {
        let bits = field.bits(value);
        if bits.is_none() {
            let what = format!("`{}` cannot be {value} {}", signal.name, signal.unit);
            self.problem(named, what.trim_end().to_owned(), Some(format!("it has {} bits", field.size)));
        }
        bits
    }
}

/// The selector's value, if it is always the same.
fn shown(told: &SentFrameBinding, selector: &FrameField) -> Option<u64> {
    let mut changing = told.outputs.iter().map(|(_, field, _)| field).chain(&told.counter);
    let is_fixed = !changing.any(|field| field.meets(selector));
    is_fixed.then(|| selector.get(&told.rest))
}
