//! A description in the names of a DBC file → numbers, with every problem at its place in the description.

use linewright_line::{
    Checksum, DbcName, FrameBinding, FrameField, FrameTable, Page, Problem, ReceivedFrameBinding, ReceivedMessageTable,
    When, suggestion,
};

use crate::{Database, DbcMessage, DbcSignal, Mux};

/// Bytes of a classic frame.
const LEN_MAX: u64 = 8;
/// A counter of fewer bits comes round too soon to show that a frame is new.
const COUNTER_BITS_MIN: u8 = 2;

/// Binds `frames` to `database`: all problems at once, each pointing into the description.
pub fn bind(frames: &FrameTable, database: &Database) -> Result<FrameBinding, Vec<Problem>> {
    let mut binder = Binder { database, file: &frames.file.name, problems: Vec::new() };
    let heard: Vec<_> = frames.receive.iter().filter_map(|receive| binder.heard(receive)).collect();
    let told = binder.all_told(&frames.send);
    binder.heard_once(&frames.receive);
    if binder.problems.is_empty() { Ok(FrameBinding { heard, told }) } else { Err(binder.problems) }
}

pub(crate) struct Binder<'a> {
    database: &'a Database,
    file: &'a str,
    problems: Vec<Problem>,
}

impl<'a> Binder<'a> {
    pub(crate) fn problem(&mut self, at: &DbcName, message: String, hint: Option<String>) {
        self.problems.push(Problem::error(at.at.clone(), message).maybe_hint(hint));
    }

    pub(crate) fn message(&mut self, named: &DbcName) -> Option<&'a DbcMessage> {
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

    pub(crate) fn signal(&mut self, message: &'a DbcMessage, named: &DbcName) -> Option<(&'a DbcSignal, FrameField)> {
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
    fn plain(&mut self, message: &'a DbcMessage, named: &DbcName, what: &str) -> Option<FrameField> {
        let (signal, field) = self.signal(message, named)?;
        if matches!(signal.mux, Mux::Selected(_) | Mux::Nested) {
            self.problem(named, format!("`{}` is not in every frame, as {what} must be", signal.name), None);
            return None;
        }
        Some(field)
    }

    pub(crate) fn counter(&mut self, message: &'a DbcMessage, named: Option<&DbcName>) -> Option<Option<FrameField>> {
        let Some(named) = named else { return Some(None) };
        let field = self.plain(message, named, "a counter")?;
        if field.size < COUNTER_BITS_MIN {
            self.problem(named, format!("`{}` has one bit, too few to count with", named.name), None);
            return None;
        }
        Some(Some(field))
    }

    pub(crate) fn checksum(
        &mut self,
        message: &'a DbcMessage,
        named: Option<&(DbcName, Checksum)>,
    ) -> Option<Option<(u8, Checksum)>> {
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

    /// The selector that shows the multiplexed signal `named`.
    pub(crate) fn selector(&mut self, message: &'a DbcMessage, named: &DbcName) -> Option<FrameField> {
        let selector = message.selector().map(|(_, field)| field);
        if selector.is_none() {
            self.problem(
                named,
                format!("message `{}` has no usable selector for `{}`", message.name, named.name),
                None,
            );
        }
        selector
    }

    fn heard(&mut self, receive: &ReceivedMessageTable) -> Option<ReceivedFrameBinding> {
        let message = self.message(&receive.message)?;
        let counter = self.counter(message, receive.counter.as_ref());
        let checksum = self.checksum(message, receive.checksum.as_ref());
        self.apart(message, receive.counter.iter().chain(receive.checksum.iter().map(|(named, _)| named)), None);
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
            let (least, most) = within(signal, &field);
            self.condition_is_possible(&input.signal, signal, &field, input.when);
            let nth = pages.iter().position(|page| page.selected == selected).unwrap_or_else(|| {
                pages.push(Page { selected, inputs: Vec::new(), limits: Vec::new() });
                pages.len() - 1
            });
            pages[nth].inputs.push((input.input, field, input.when));
            let limits = (field, least, most);
            if (least, most) != field.range() && !pages[nth].limits.contains(&limits) {
                pages[nth].limits.push(limits);
            }
        }
        if pages.is_empty() {
            pages.push(Page { selected: None, inputs: Vec::new(), limits: Vec::new() });
        }
        Some(ReceivedFrameBinding {
            name: message.name.clone(),
            id: message.id,
            len: message.len as u8,
            timeout: receive.timeout,
            counter: counter?,
            checksum: checksum?,
            pages,
        })
    }

    fn condition_is_possible(&mut self, at: &DbcName, signal: &DbcSignal, field: &FrameField, when: When) {
        let (least, most) = within(signal, field);
        let unit = &signal.unit;
        let has =
            || Some(format!("by {} it has values from {least} to {most} {unit}", self.file).trim_end().to_owned());
        if least > most {
            let (first, last) = field.range();
            let what = format!("no value of `{}` is within its limits in {}", signal.name, self.file);
            self.problem(at, what, Some(format!("its bits hold {first} to {last} {unit}").trim_end().to_owned()));
            return;
        }
        match when {
            When::Bit(bit) if bit >= field.size => {
                self.problem(at, format!("`{}` has {} bits, and no bit {bit}", signal.name, field.size), None);
            }
            When::Equals(value) => {
                let nearest = field.bits(value).map(|bits| field.value(bits));
                let step = field.factor.abs() * 1e-6;
                let hint = match nearest {
                    Some(nearest) if !(least..=most).contains(&nearest) => has(),
                    Some(nearest) if (nearest - value).abs() <= step => return,
                    Some(nearest) => Some(format!("the nearest value is {nearest}")),
                    None => has(),
                };
                let what = format!("`{}` is never {value} {unit}", signal.name);
                self.problem(at, what.trim_end().to_owned(), hint);
            }
            When::Above { at: limit, .. } | When::Below { at: limit, .. } => {
                if let Some(fault) = when.out_of_reach(least, most) {
                    let hint = has();
                    let what = format!("`{}` has a limit that {fault}: {limit} {unit}", signal.name);
                    self.problem(at, what.trim_end().to_owned(), hint);
                }
            }
            When::NotZero | When::Bit(_) => {}
        }
    }

    /// A message is listed once: its timeout and its counter are its own.
    fn heard_once(&mut self, receive: &[ReceivedMessageTable]) {
        for (nth, this) in receive.iter().enumerate() {
            if receive[..nth].iter().any(|earlier| earlier.message.name == this.message.name) {
                let what = format!("message `{}` is received twice", this.message.name);
                self.problem(&this.message, what, Some("put all its inputs into one entry".to_owned()));
            }
        }
    }

    /// Each of these signals has one meaning in a frame, and bits of its own; so has `other`, which is there besides.
    pub(crate) fn apart<'n>(
        &mut self,
        message: &'a DbcMessage,
        named: impl Iterator<Item = &'n DbcName>,
        other: Option<&'a DbcSignal>,
    ) {
        let lies = |signal: &DbcSignal| signal.field.filter(|field| field.fits(message.len as u8));
        let place = |signal: &'a DbcSignal| Some((signal.name.as_str(), lies(signal)?));
        let mut seen: Vec<(&str, FrameField)> = other.and_then(place).into_iter().collect();
        for named in named {
            let signal = message.signals.iter().find(|signal| signal.name == named.name);
            let Some((name, field)) = signal.and_then(place) else { continue };
            if seen.iter().any(|(earlier, _)| *earlier == name) {
                self.problem(named, format!("`{name}` is given two values"), None);
            } else if let Some((other, _)) = seen.iter().find(|(_, other)| other.meets(&field)) {
                self.problem(named, format!("`{other}` and `{name}` share bits"), None);
            }
            seen.push((name, field));
        }
    }
}

/// The least and the greatest value of a signal: the range of its bits, limited by the file's. A limit between two
/// values is taken as the nearer one.
fn within(signal: &DbcSignal, field: &FrameField) -> (f64, f64) {
    let (first, last) = field.range();
    let nearest = |limit: f64| field.bits(limit).map_or(limit, |bits| field.value(bits));
    let limits = signal.limits.map(|(least, most)| (nearest(least).max(first), nearest(most).min(last)));
    limits.unwrap_or((first, last))
}
