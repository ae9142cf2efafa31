//! The stations together: what may happen next, and what comes of it.
//!
//! Whatever happens to a station happens by itself; then its new report goes on its way to every reader for whom it
//! says something new, and takes the place of an older one that has not been heard. That is the whole of what joins
//! stations: there is no other way for one to learn of another.

use linewright_line::StationId;
use linewright_line::net::StationNet;
use linewright_station_logic::{CompileError, Event};

use super::setting::{Grants, Setting};
use super::state::{Layout, State, Widths};
use super::station::{ANY_MODE, Act, Effect, Situation, Situations};
use super::word::{Word, Words};

/// How far apart the cycles of two neighbours may be. A pair of arrows, one of lag 0 and one of lag 1, lets the one be
/// a cycle ahead; operations listed before the arrow's end may have begun another.
const CYCLES_APART_MAX: i32 = 2;

/// A view that is this many cycles behind has long been too old to be relied on, and unknown blocks: the reader hears
/// the report that would put it there. Without a bound, a view that no arrow of the present mode reads could fall
/// behind for ever.
const CYCLES_BEHIND_MAX: i32 = 4;

/// One thing that happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Move {
    /// To a station by itself: the number of the act among those of its situation.
    Act { station: usize, nth: usize },
    /// A reader hears a word on its way to it; the ones before it are lost.
    Hear { link: usize, nth: usize },
    /// Another mode is granted: the number of it among those of the setting.
    Grant(usize),
}

/// The mode that is granted, by its number, and the stations that act on it, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Granted {
    pub mode: u8,
    pub acting: u32,
}

/// What must never be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrong {
    /// Both states of a conflict hold.
    Conflict(usize),
    /// Something about one station by itself.
    Station(usize),
    /// The least and the greatest cycle of a station.
    Apart(i32, i32),
}

/// The stations with their situations and words, and the line's own rules.
#[derive(Debug)]
pub(crate) struct System {
    pub setting: Setting,
    pub stations: Vec<Situations>,
    pub words: Vec<Words>,
    /// For each link, its position among the reader's incoming ones.
    nth_incoming: Vec<usize>,
}

impl System {
    pub fn new(setting: &Setting) -> Result<(Self, State), CompileError> {
        let line = &setting.line;
        let transitions = |id| StationNet::of(line, id).transitions().len();
        let stations = line.station_ids().map(|id| Situations::new(setting, id.index(), transitions(id))).collect();
        let with_cycle = !setting.rules.counted;
        let words = setting.links.iter().map(|link| Words::new(with_cycle, link.counts.len())).collect();
        let nth_incoming = (0..setting.links.len())
            .map(|link| setting.into(setting.links[link].reader).position(|l| l == link).unwrap_or(0))
            .collect();
        let mut system = System { setting: setting.clone(), stations, words, nth_incoming };
        let start = system.start()?;
        Ok((system, start))
    }

    /// All stations at home in stand-by, having heard each other.
    fn start(&mut self) -> Result<State, CompileError> {
        let ids = self.setting.line.station_ids();
        let mut nodes =
            ids.map(|id| Situation::at_home(&self.setting, id)).collect::<Result<Vec<_>, CompileError>>()?;
        for link in 0..self.setting.links.len() {
            let (writer, reader) = (self.setting.links[link].writer, self.setting.links[link].reader);
            let word = nodes[writer].says(&self.setting, link, &mut self.words[link]);
            let apart = nodes[writer].controller.cycle() - nodes[reader].controller.cycle();
            let word = word.shifted(apart, &self.words[link]);
            nodes[reader].hear(&self.setting, &self.words, link, self.nth_incoming[link], word, &mut Vec::new());
        }
        let cycles = nodes.iter().map(|node| node.controller.cycle()).collect();
        let mut situations = Vec::new();
        for (station, node) in nodes.into_iter().enumerate() {
            situations.push(self.stations[station].enter(&self.setting, &mut self.words, node));
        }
        let mail = vec![Word::NONE; self.setting.links.len() * self.setting.lag];
        Ok(State { granted: 0, situations, cycles, mail })
    }

    pub fn layout(&self, widths: Widths) -> Layout {
        let bases = self.words.iter().map(Words::has_base);
        Layout::new(self.stations.len(), bases, self.setting.lag, widths)
    }

    /// Everything that may happen in this state.
    pub fn moves(&mut self, state: &State) -> Vec<Move> {
        let mut moves = Vec::new();
        for link in 0..self.setting.links.len() {
            moves.extend((0..self.waiting(state, link)).map(|nth| Move::Hear { link, nth }));
        }
        for station in 0..self.stations.len() {
            let acts = 0..self.acts(state, station);
            let possible = acts.filter(|&nth| self.act(state, station, nth).is_some());
            moves.extend(possible.map(|nth| Move::Act { station, nth }));
        }
        moves.extend(self.grants(state).map(Move::Grant));
        moves
    }

    /// How many words are on their way over a link.
    #[inline]
    pub fn waiting(&self, state: &State, link: usize) -> usize {
        let lag = self.setting.lag;
        state.mail[link * lag..][..lag].iter().take_while(|word| word.id != 0).count()
    }

    /// The modes that may be granted next, by number.
    pub fn grants(&self, state: &State) -> impl Iterator<Item = usize> + use<> {
        let may = self.setting.grants == Grants::InEpochs && self.all_idle(state);
        let (modes, granted) = (if may { self.setting.modes.len() } else { 0 }, state.granted as usize);
        (0..modes).filter(move |&mode| mode != granted)
    }

    fn all_idle(&self, state: &State) -> bool {
        self.granted(state).acting == 0
    }

    /// The mode that is granted, and who acts on it.
    pub fn granted(&self, state: &State) -> Granted {
        let stations = self.stations.iter().zip(&state.situations).enumerate();
        let acting = stations.fold(0, |bits, (nth, (station, &number))| {
            bits | u32::from(station.facts[number as usize].acts_on_a_mode) << nth
        });
        Granted { mode: state.granted as u8, acting }
    }

    /// How many acts there are for a station in this state, possible or not.
    #[inline]
    pub fn acts(&self, state: &State, station: usize) -> usize {
        self.stations[station].facts[state.situations[station] as usize].acts.len()
    }

    /// What an act comes to, if it can happen in this state.
    #[inline]
    pub fn act(&mut self, state: &State, station: usize, nth: usize) -> Option<Effect> {
        let from = state.situations[station];
        let effect = self.stations[station].effect(&self.setting, &mut self.words, from, nth);
        (effect.granted == ANY_MODE || u32::from(effect.granted) == state.granted).then_some(effect)
    }

    /// Lets it happen.
    pub fn play(&mut self, state: &mut State, what: Move) {
        match what {
            Move::Act { station, nth } => {
                let from = state.situations[station];
                let effect = self.stations[station].effect(&self.setting, &mut self.words, from, nth);
                self.happen(state, station, effect);
            }
            Move::Grant(mode) => state.granted = mode as u32,
            Move::Hear { link, nth } => {
                let lag = self.setting.lag;
                let slots = &mut state.mail[link * lag..][..lag];
                let word = slots[nth];
                slots.rotate_left(nth + 1);
                slots[lag - nth - 1..].fill(Word::NONE);
                self.deliver(state, link, word);
            }
        }
    }

    /// An act takes effect, all of it.
    pub fn happen(&mut self, state: &mut State, station: usize, effect: Effect) {
        self.come_to(state, station, effect);
        if effect.off_follows {
            let from = state.situations[station];
            let effect = self.stations[station].off(&self.setting, &mut self.words, from);
            self.come_to(state, station, effect);
        }
    }

    fn deliver(&mut self, state: &mut State, link: usize, word: Word) {
        let reader = self.setting.links[link].reader;
        let word = word.shifted(-state.cycles[reader], &self.words[link]);
        let (from, nth) = (state.situations[reader], self.nth_incoming[link]);
        let effect = self.stations[reader].hear(&self.setting, &mut self.words, from, nth, word);
        self.come_to(state, reader, effect);
    }

    fn come_to(&mut self, state: &mut State, station: usize, effect: Effect) {
        state.situations[station] = effect.to;
        state.cycles[station] += effect.cycles;
        if effect.closed {
            self.close(state, station);
        }
        if !effect.quiet {
            self.post(state, station);
        }
    }

    /// What it had asked for is not open any more: answers to it are worth nothing, wherever they are.
    fn close(&mut self, state: &mut State, writer: usize) {
        let lag = self.setting.lag;
        for at in 0..self.stations[writer].outgoing.len() {
            let link = self.stations[writer].outgoing[at];
            let reader = self.setting.links[link].reader;
            let (from, nth) = (state.situations[reader], self.nth_incoming[link]);
            state.situations[reader] = self.stations[reader].close(&self.setting, &mut self.words, from, nth);
            for word in &mut state.mail[link * lag..][..lag] {
                *word = self.words[link].closed(*word);
            }
            let reverse = self.setting.links[link].reverse;
            for word in &mut state.mail[reverse * lag..][..lag] {
                *word = self.words[reverse].unanswered(*word);
            }
        }
    }

    /// The station's report goes on its way to every reader for whom it says something new.
    fn post(&mut self, state: &mut State, writer: usize) {
        let lag = self.setting.lag;
        for at in 0..self.stations[writer].outgoing.len() {
            let link = self.stations[writer].outgoing[at];
            let (word, newest) = (self.said(state, link), self.newest(state, link));
            if word == newest {
                continue;
            }
            let has_base = self.words[link].has_base();
            if lag == 0 || (has_base && word.base - self.held(state, link).base >= CYCLES_BEHIND_MAX) {
                state.mail[link * lag..][..lag].fill(Word::NONE);
                self.deliver(state, link, word);
                continue;
            }
            let slots = &mut state.mail[link * lag..][..lag];
            match slots.iter_mut().find(|slot| slot.id == 0) {
                Some(free) => *free = word,
                None => {
                    slots.rotate_left(1);
                    slots[lag - 1] = word;
                }
            }
        }
    }

    /// What the writer of a link says now.
    fn said(&self, state: &State, link: usize) -> Word {
        let writer = self.setting.links[link].writer;
        let situations = &self.stations[writer];
        let at = situations.outgoing.iter().position(|&l| l == link).unwrap_or(0);
        let word = situations.facts[state.situations[writer] as usize].says[at];
        word.shifted(state.cycles[writer], &self.words[link])
    }

    /// The newest word the reader of a link has heard or may still hear.
    fn newest(&self, state: &State, link: usize) -> Word {
        let lag = self.setting.lag;
        let waiting = state.mail[link * lag..][..lag].iter().rev().find(|word| word.id != 0);
        waiting.copied().unwrap_or_else(|| self.held(state, link))
    }

    /// What the reader of a link holds.
    fn held(&self, state: &State, link: usize) -> Word {
        let reader = self.setting.links[link].reader;
        let held = self.stations[reader].facts[state.situations[reader] as usize].holds[self.nth_incoming[link]];
        held.shifted(state.cycles[reader], &self.words[link])
    }

    /// The first thing that is wrong in this state.
    pub fn wrong(&self, state: &State) -> Option<Wrong> {
        let facts = || self.stations.iter().zip(&state.situations).map(|(s, &number)| &s.facts[number as usize]);
        let in_a = facts().fold(0, |bits, facts| bits | facts.in_a);
        let in_b = facts().fold(0, |bits, facts| bits | facts.in_b);
        if in_a & in_b != 0 {
            return Some(Wrong::Conflict((in_a & in_b).trailing_zeros() as usize));
        }
        let station = facts().position(|facts| facts.wrong.is_some()).map(Wrong::Station);
        station.or_else(|| self.cycles_apart(state).map(|(least, most)| Wrong::Apart(least, most)))
    }

    /// What is wrong, in words.
    pub fn wrong_text(&self, state: &State, wrong: Wrong) -> String {
        match wrong {
            Wrong::Conflict(nth) => self.setting.line.conflicts[nth].why.clone(),
            Wrong::Station(station) => {
                let facts = &self.stations[station].facts[state.situations[station] as usize];
                let what = facts.wrong.as_deref().unwrap_or("nothing is wrong");
                format!("{}: {what}", self.setting.line.stations[station].name)
            }
            Wrong::Apart(least, most) => format!("stations are in cycles {least} and {most}, too far apart"),
        }
    }

    fn cycles_apart(&self, state: &State) -> Option<(i32, i32)> {
        let (least, most) = (state.cycles.iter().min()?, state.cycles.iter().max()?);
        let neighbours = self.stations.len() as i32 - 1;
        (most - least > CYCLES_APART_MAX * neighbours).then_some((*least, *most))
    }

    pub fn all_at_home(&self, state: &State) -> bool {
        let facts = |(s, &number): (&Situations, &u32)| s.facts[number as usize].at_home;
        self.stations.iter().zip(&state.situations).all(facts)
    }

    /// What the station concerned says about a move, if it concerns one.
    pub fn events(&self, state: &State, what: Move) -> Option<(StationId, Vec<Event>)> {
        let mut events = Vec::new();
        let station = match what {
            Move::Grant(_) => return None,
            Move::Act { station, nth } => {
                let number = state.situations[station] as usize;
                let act = self.stations[station].facts[number].acts[nth];
                let mut next = self.stations[station].all[number].clone();
                next.act(&self.setting, act, &mut events);
                if matches!(act, Act::Arrive(..) | Act::Fail(..)) {
                    next.image(0, true, &mut events);
                }
                station
            }
            Move::Hear { link, nth } => {
                let reader = self.setting.links[link].reader;
                let word = state.mail[link * self.setting.lag + nth];
                let word = word.shifted(-state.cycles[reader], &self.words[link]);
                let mut next = self.stations[reader].all[state.situations[reader] as usize].clone();
                next.hear(&self.setting, &self.words, link, self.nth_incoming[link], word, &mut events);
                reader
            }
        };
        Some((StationId::at(station), events))
    }

    pub fn bytes(&self) -> usize {
        self.stations.iter().map(Situations::bytes).sum()
    }
}
