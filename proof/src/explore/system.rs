//! The stations together: possible moves, and their results.
//!
//! Whatever happens to a station happens by itself; then its new report goes on its way to every reader for which its
//! view key is new, and replaces an older one not yet received. Stations are joined by nothing else.

use linewright_line::StationId;
use linewright_line::net::{ControlMode, StationNet};
use linewright_station_logic::{CompileError, StationHappening};

use super::classes::{Classes, LocalClass, MemberAct};
use super::setting::{Grants, LineExploration};
use super::state::{ComposedState, StateLayout, Widths};
use super::station::{Effect, Situation, Situations, StationAct};
use super::view_key::{ViewKey, ViewKeys};

/// A view that is this many cycles behind has long been too old to be relied on, and unknown blocks: the reader
/// receives the report that would put it there. Without a bound, a view that no arrow of the present mode reads could
/// fall behind for ever.
const CYCLES_BEHIND_MAX: i32 = 4;

/// One thing that happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SystemMove {
    /// To a station by itself: the number of the act among those of its situation.
    Act { station: usize, nth: usize },
    /// A reader receives a view key on its way to it; the ones before it are lost.
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

/// The stations with their situations and words, and the line's own rules.
#[derive(Debug)]
pub(crate) struct System {
    pub setting: LineExploration,
    pub stations: Vec<Situations>,
    pub words: Vec<ViewKeys>,
    /// For each station and each mode that may be granted, what it comes and goes between by itself.
    classes: Vec<Vec<Classes>>,
    /// Bytes, about, when a class was last added.
    pub bytes_classified: usize,
    /// For each link, its position among the reader's incoming ones.
    nth_incoming: Vec<usize>,
    /// For each link, its position among the writer's outgoing ones.
    nth_outgoing: Vec<usize>,
}

/// A station of which several situations are considered at once, and now it matters which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RelevantStation(pub usize);

/// A station in one situation of its class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FixedSituation {
    pub station: usize,
    pub member: u32,
}

/// The modes in their order. They are numbered, and twice the same would count states twice.
fn each_once(modes: &[ControlMode]) -> Vec<ControlMode> {
    let mut each = Vec::new();
    for mode in modes {
        if !each.contains(mode) {
            each.push(*mode);
        }
    }
    each
}

impl System {
    pub fn new(setting: &LineExploration) -> Result<(Self, ComposedState), CompileError> {
        let setting = &LineExploration { modes: each_once(&setting.modes), ..setting.clone() };
        let line = &setting.line;
        let transitions = |id| StationNet::of(line, id).transitions().len();
        let stations = line.station_ids().map(|id| Situations::new(setting, id.index(), transitions(id))).collect();
        let with_cycle = !setting.rules.counted;
        let words = setting.links.iter().map(|link| ViewKeys::new(with_cycle, link.counts.len())).collect();
        let nth_incoming = (0..setting.links.len())
            .map(|link| setting.into(setting.links[link].reader).position(|l| l == link).unwrap_or(0))
            .collect();
        let nth_outgoing = (0..setting.links.len())
            .map(|link| setting.out_of(setting.links[link].writer).position(|l| l == link).unwrap_or(0))
            .collect();
        // Where no mode may be granted, none is from the start to the end.
        let grants = setting.modes.len().max(1);
        let classes = line.station_ids().map(|_| vec![Classes::default(); grants]).collect();
        let setting = setting.clone();
        let mut system = System { setting, stations, words, classes, bytes_classified: 0, nth_incoming, nth_outgoing };
        let start = system.start()?;
        Ok((system, start))
    }

    /// All stations at home in stand-by, with each other's reports received.
    fn start(&mut self) -> Result<ComposedState, CompileError> {
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
        let mail = vec![ViewKey::NONE; self.setting.links.len() * self.setting.lag];
        Ok(ComposedState { granted: 0, situations, cycles, mail })
    }

    pub fn layout(&self, widths: Widths) -> StateLayout {
        let bases = self.words.iter().map(ViewKeys::has_base);
        StateLayout::new(self.stations.len(), bases, self.setting.lag, widths)
    }

    /// Number of view keys on their way over a link.
    #[inline]
    pub fn waiting(&self, state: &ComposedState, link: usize) -> usize {
        let lag = self.setting.lag;
        state.mail[link * lag..][..lag].iter().take_while(|word| word.id != 0).count()
    }

    /// The class of a station's situation. A state that the search keeps has one situation of each.
    #[inline]
    pub fn class(&self, state: &ComposedState, station: usize) -> &LocalClass {
        self.classes[station][state.granted as usize].at(state.situations[station])
    }

    /// Every station comes to the situation that stands for its class.
    #[inline]
    pub fn settle(&mut self, state: &mut ComposedState) {
        let granted = state.granted as usize;
        for station in 0..state.situations.len() {
            state.situations[station] = self.settled(station, granted, state.situations[station]);
        }
        if self.setting.forgets {
            self.settle_cycles(state);
        }
    }

    /// The situation that stands for the class of this one while a mode is granted.
    #[inline]
    fn settled(&mut self, station: usize, granted: usize, situation: u32) -> u32 {
        match self.classes[station][granted].known(situation) {
            Some(known) => known,
            None => self.classify(station, granted, situation),
        }
    }

    /// Situations of a station's class in which it acts on no mode: one for each class that they are in once another
    /// mode is granted.
    pub fn idle_by_class(&mut self, state: &ComposedState, station: usize, mode: usize) -> Vec<u32> {
        let mut one_each: Vec<(u32, u32)> = Vec::new();
        for nth in 0..self.class(state, station).idle.len() {
            let member = self.class(state, station).idle[nth];
            one_each.push((self.settled(station, mode, member), member));
        }
        one_each.sort_unstable();
        one_each.dedup_by_key(|&mut (class, _)| class);
        one_each.into_iter().map(|(_, member)| member).collect()
    }

    #[cold]
    fn classify(&mut self, station: usize, granted: usize, situation: u32) -> u32 {
        let classes = &mut self.classes[station][granted];
        classes.enter(&self.setting, &mut self.words, &mut self.stations[station], granted, situation);
        let known = classes.known(situation).unwrap_or(situation);
        self.bytes_classified = self.bytes();
        known
    }

    /// The acts by which a station comes to another situation of its class by itself.
    pub fn walk(&mut self, state: &ComposedState, pin: FixedSituation) -> Vec<MemberAct> {
        let FixedSituation { station, member } = pin;
        let (granted, from) = (state.granted as usize, state.situations[station]);
        let of = &mut self.stations[station];
        self.classes[station][granted].walk(&self.setting, &mut self.words, of, granted, (from, member))
    }

    /// The stations of which this state stands for several situations, a bit each.
    #[inline]
    pub fn loose(&self, state: &ComposedState) -> u32 {
        let several = |station: usize| u32::from(self.class(state, station).members.len() > 1);
        (0..self.stations.len()).fold(0, |bits, station| bits | several(station) << station)
    }

    /// The modes that may be granted next, by number.
    pub fn grants(&self, state: &ComposedState) -> impl Iterator<Item = usize> + use<> {
        let may = self.setting.grants == Grants::InEpochs
            && (0..self.stations.len()).all(|station| !self.class(state, station).idle.is_empty());
        let (modes, granted) = (if may { self.setting.modes.len() } else { 0 }, state.granted as usize);
        let manual = self.setting.modes.iter().position(|&mode| mode == ControlMode::Manual);
        let is_lost = (0..self.stations.len()).any(|station| self.is_lost(state, station));
        let without = manual.filter(|_| is_lost);
        (0..modes).filter(move |&mode| mode != granted && Some(mode) != without)
    }

    /// The mode that is granted, and the stations that act on it and cannot leave it by themselves.
    pub fn granted(&self, state: &ComposedState) -> Granted {
        let acts = |station: usize| u32::from(self.class(state, station).idle.is_empty());
        let acting = (0..self.stations.len()).fold(0, |bits, station| bits | acts(station) << station);
        Granted { mode: state.granted as u8, acting }
    }

    /// Performs a move. Of a loose station its view keys, given and held, may be read, as they are the same in all
    /// situations of its class; where anything else is needed the state is left half-done, to be tried again for each
    /// of them.
    pub fn play(&mut self, state: &mut ComposedState, what: SystemMove, loose: u32) -> Result<(), RelevantStation> {
        match what {
            SystemMove::Act { station, nth } => {
                let from = state.situations[station];
                let act = self.stations[station].facts[from as usize].acts[nth];
                let effect = self.stations[station].effect(&self.setting, &mut self.words, from, nth);
                if act == StationAct::Forget {
                    self.lose_mail(state, station);
                }
                self.come_to(state, station, effect, loose)?;
                if effect.off_follows {
                    let from = state.situations[station];
                    let effect = self.stations[station].off(&self.setting, &mut self.words, from);
                    self.come_to(state, station, effect, loose)?;
                }
                Ok(())
            }
            SystemMove::Grant(mode) => {
                state.granted = mode as u32;
                Ok(())
            }
            SystemMove::Hear { link, nth } => {
                let lag = self.setting.lag;
                let slots = &mut state.mail[link * lag..][..lag];
                let word = slots[nth];
                slots.rotate_left(nth + 1);
                slots[lag - nth - 1..].fill(ViewKey::NONE);
                self.deliver(state, link, word, loose)
            }
        }
    }

    fn deliver(
        &mut self,
        state: &mut ComposedState,
        link: usize,
        word: ViewKey,
        loose: u32,
    ) -> Result<(), RelevantStation> {
        let reader = self.setting.links[link].reader;
        if self.is_lost(state, reader) {
            return Ok(());
        }
        if loose & (1 << reader) != 0 {
            return Err(RelevantStation(reader));
        }
        let word = word.shifted(-state.cycles[reader], &self.words[link]);
        let (from, nth) = (state.situations[reader], self.nth_incoming[link]);
        let effect = self.stations[reader].hear(&self.setting, &mut self.words, from, nth, word);
        self.come_to(state, reader, effect, loose)
    }

    fn come_to(
        &mut self,
        state: &mut ComposedState,
        station: usize,
        effect: Effect,
        loose: u32,
    ) -> Result<(), RelevantStation> {
        state.situations[station] = effect.to;
        state.cycles[station] += effect.cycles;
        if effect.closed {
            self.close(state, station, loose)?;
        }
        if effect.quiet { Ok(()) } else { self.post(state, station, loose) }
    }

    /// Its request is not open any more: answers to it are void, wherever they are.
    fn close(&mut self, state: &mut ComposedState, writer: usize, loose: u32) -> Result<(), RelevantStation> {
        let lag = self.setting.lag;
        for at in 0..self.stations[writer].outgoing.len() {
            let link = self.stations[writer].outgoing[at];
            let reader = self.setting.links[link].reader;
            let (from, nth) = (state.situations[reader], self.nth_incoming[link]);
            if self.stations[reader].minds_closing(&self.setting, from, nth) {
                if loose & (1 << reader) != 0 {
                    return Err(RelevantStation(reader));
                }
                state.situations[reader] = self.stations[reader].close(&self.setting, &mut self.words, from, nth);
            }
            for word in &mut state.mail[link * lag..][..lag] {
                *word = self.words[link].closed(*word);
            }
            let reverse = self.setting.links[link].reverse;
            for word in &mut state.mail[reverse * lag..][..lag] {
                *word = self.words[reverse].unanswered(*word);
            }
        }
        Ok(())
    }

    /// The station's report goes on its way to every reader for which its view key is new.
    fn post(&mut self, state: &mut ComposedState, writer: usize, loose: u32) -> Result<(), RelevantStation> {
        let lag = self.setting.lag;
        for at in 0..self.stations[writer].outgoing.len() {
            let link = self.stations[writer].outgoing[at];
            if self.is_lost(state, self.setting.links[link].reader) {
                continue;
            }
            let (word, newest) = (self.said(state, link), self.newest(state, link));
            if word == newest {
                continue;
            }
            let has_base = self.words[link].has_base();
            let is_apart = has_base && word.has_base() && word.base - self.held(state, link).base >= CYCLES_BEHIND_MAX;
            if lag == 0 || is_apart {
                state.mail[link * lag..][..lag].fill(ViewKey::NONE);
                self.deliver(state, link, word, loose)?;
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
        Ok(())
    }

    /// Whether a station has lost its memory; the same throughout a class. Reports it receives cannot be compared, as
    /// if it received none.
    fn is_lost(&self, state: &ComposedState, station: usize) -> bool {
        self.setting.forgets && self.stations[station].facts[state.situations[station] as usize].is_lost
    }

    fn lose_mail(&mut self, state: &mut ComposedState, reader: usize) {
        let lag = self.setting.lag;
        for at in 0..self.stations[reader].incoming.len() {
            let link = self.stations[reader].incoming[at];
            state.mail[link * lag..][..lag].fill(ViewKey::NONE);
        }
    }

    /// A cycle that is compared with no other is as good as any: the greatest of the others.
    fn settle_cycles(&self, state: &mut ComposedState) {
        let compared = (0..state.cycles.len()).filter(|&station| !self.is_lost(state, station));
        let greatest = compared.map(|station| state.cycles[station]).max().unwrap_or(0);
        for station in 0..state.cycles.len() {
            if self.is_lost(state, station) {
                state.cycles[station] = greatest;
            }
        }
    }

    /// View key of the writer of a link now.
    fn said(&self, state: &ComposedState, link: usize) -> ViewKey {
        let writer = self.setting.links[link].writer;
        let facts = &self.stations[writer].facts[state.situations[writer] as usize];
        let word = facts.says[self.nth_outgoing[link]];
        word.shifted(state.cycles[writer], &self.words[link])
    }

    /// Newest view key that the reader of a link has received or may still receive.
    fn newest(&self, state: &ComposedState, link: usize) -> ViewKey {
        let lag = self.setting.lag;
        let waiting = state.mail[link * lag..][..lag].iter().rev().find(|word| word.id != 0);
        waiting.copied().unwrap_or_else(|| self.held(state, link))
    }

    /// View key that the reader of a link holds.
    fn held(&self, state: &ComposedState, link: usize) -> ViewKey {
        let reader = self.setting.links[link].reader;
        let held = self.stations[reader].facts[state.situations[reader] as usize].holds[self.nth_incoming[link]];
        held.shifted(state.cycles[reader], &self.words[link])
    }

    /// Events of the station concerned in a move, if it concerns one.
    pub fn events(&self, state: &ComposedState, what: SystemMove) -> Option<(StationId, Vec<StationHappening>)> {
        let mut events = Vec::new();
        let station = match what {
            SystemMove::Grant(_) => return None,
            SystemMove::Act { station, nth } => {
                let number = state.situations[station] as usize;
                let act = self.stations[station].facts[number].acts[nth];
                let mut next = self.stations[station].all[number].clone();
                next.act(&self.setting, act, &mut events);
                if matches!(act, StationAct::Arrive(..) | StationAct::Fail(..)) {
                    next.image(0, true, &mut events);
                }
                station
            }
            SystemMove::Hear { link, nth } => {
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
        let classes: usize = self.classes.iter().flatten().map(Classes::bytes).sum();
        classes + self.stations.iter().map(Situations::bytes).sum::<usize>()
    }
}
