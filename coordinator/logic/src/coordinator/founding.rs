//! Founding a generation: the moment from which the stations' counts may be compared (see the module `generation` of
//! `linewright_station_logic`; the published design has no such numbers).
//!
//! The coordinator stores no generation. The line has one while all stations that compare counts report the same one. If
//! they do not, the first *start*, *auto* or *hand*, or *manual* at home, given while every station is at home by its
//! switches founds a new one: a number is drawn and sent, in orders that name the boot id of each station, so that a station
//! restarted since ignores it. Motion is enabled when all have taken it. A station that is restarted meanwhile, or leaves home before taking
//! it, ends the founding; the next such command begins another.

use linewright_line::{StationId, Tick};
use linewright_random::mix;

use super::{Coordinator, StationView};
use crate::refusal::{ApartCause, ModeRefusal};

/// A generation that is being founded.
#[derive(Clone, Debug)]
pub(super) struct OpenFounding {
    generation: u64,
    /// For each station, its boot id when it was seen at home.
    lives: Vec<u64>,
    manual_waits_until: Tick,
}

impl Coordinator {
    /// The generation that is being founded, for the lives of the stations that are received ([`Coordinator::life_of`]).
    pub fn founding(&self) -> Option<u64> {
        self.founding.as_ref().map(|founding| founding.generation)
    }

    /// The stations whose counts others compare with, or that compare with others'.
    fn comparing(&self) -> impl Iterator<Item = (StationId, &StationView)> {
        let all = self.line.station_ids().zip(&self.stations);
        all.filter(|(_, station)| station.compares).map(|(id, station)| (id, &station.heard))
    }

    /// The generation that the most stations report; 0 where none has one.
    fn prevailing(&self) -> u64 {
        let count = |generation: u64| self.comparing().filter(|(_, heard)| heard.generation == generation).count();
        let generations = self.comparing().map(|(_, heard)| heard.generation).filter(|&generation| generation != 0);
        // The greater number decides between equals, so that equal reports give the same station.
        generations.max_by_key(|&generation| (count(generation), generation)).unwrap_or(0)
    }

    /// Whether all stations that compare counts are of one generation, as far as they were received.
    pub(super) fn is_of_one_generation(&self) -> bool {
        let mut all = self.comparing();
        let Some((_, first)) = all.next() else { return true };
        first.generation != 0 && all.all(|(_, heard)| heard.generation == first.generation)
    }

    /// The stations whose generation is missing or differs from the most common one; none while a generation is being founded.
    pub(super) fn apart(&self) -> impl Iterator<Item = (StationId, ApartCause)> {
        let is_common = self.founding.is_some() || self.is_of_one_generation();
        let prevailing = self.prevailing();
        let apart = move |heard: &StationView| match heard.generation {
            0 => Some(ApartCause::NoMemory),
            generation => (generation != prevailing).then_some(ApartCause::OtherStart),
        };
        self.comparing().filter(move |_| !is_common).filter_map(move |(id, heard)| Some((id, apart(heard)?)))
    }

    /// Refusals where counts cannot be compared: the stations that have none in common, and those that are to be led home.
    pub(super) fn without_common_start(&self) -> Vec<ModeRefusal> {
        let mut reasons: Vec<ModeRefusal> =
            self.apart().map(|(id, cause)| ModeRefusal::NoCommonStart(id, cause)).collect();
        if !reasons.is_empty() {
            let away = self.comparing().filter(|(_, heard)| !heard.at_home);
            reasons.extend(away.map(|(id, _)| ModeRefusal::NotAtHome(id)));
        }
        reasons
    }

    /// Whether every station that is not left out stands at home, all in one cycle.
    pub(super) fn is_counted_home(&self) -> bool {
        self.all(|h| self.is_at_rest(h) && h.at_home) && self.all_in(self.latest_round())
    }

    /// Draws a generation if the line needs one and all stations stand at home, measured there. Called for a command that leads
    /// towards motion: with it an operator confirms what the switches measure. True if one is founded.
    pub(super) fn found(&mut self) -> bool {
        let measured = self.comparing().all(|(_, heard)| heard.devices_valid && !heard.position_lost);
        if self.is_of_one_generation() || !measured || !self.is_counted_home() {
            return false;
        }
        if self.founding.is_some() {
            return true;
        }
        self.drawn += 1;
        let generation = mix(self.boot_id ^ mix(self.epoch.wrapping_add(self.drawn << 48))).max(1);
        let lives = self.stations.iter().map(|station| station.heard.boot_id).collect();
        let manual_waits_until = self.now + self.line.timing.lease;
        self.founding = Some(OpenFounding { generation, lives, manual_waits_until });
        self.changed = true;
        true
    }

    /// Until when manual waits for the generation that is being founded: what is moved before could not be counted. A station
    /// that cannot take it holds manual up no longer than that.
    pub(super) fn manual_waits_until(&self) -> Tick {
        self.founding.as_ref().map_or(Tick::ZERO, |founding| founding.manual_waits_until)
    }

    /// Whether a station has taken the generation that is founded, or none is.
    pub(super) fn has_founded(&self, station: StationId) -> bool {
        let Some(founding) = &self.founding else { return true };
        let of = &self.stations[station.index()];
        !of.compares || of.heard.generation == founding.generation
    }

    /// Ends the founding when all have taken it, or one of them cannot any more.
    pub(super) fn follow_founding(&mut self) {
        let Some(founding) = &self.founding else { return };
        let mut taken = true;
        let mut broken = false;
        for (station, &life) in self.stations.iter().zip(&founding.lives).filter(|(station, _)| station.compares) {
            let has = station.heard.generation == founding.generation;
            taken &= has;
            let heard = &station.heard;
            // As it was measured at the command. A station that cannot take the generation must not keep manual mode disabled.
            let can = heard.at_home && heard.devices_valid && !heard.position_lost;
            broken |= heard.boot_id != life || !(has || can);
        }
        if taken || broken {
            self.founding = None;
            self.changed = true;
        }
    }
}
