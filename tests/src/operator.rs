//! Actions of operators: commands, panels, buttons; and the recovery of a line.

use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{ButtonId, InputId, Owner, StationId};
use linewright_simulation::OperatorAction;

use crate::sim::WatchedLine;

/// Time for which an operator waits for an expected event before calling for help.
const PATIENCE: Duration = Duration::from_secs(60);

impl WatchedLine {
    /// Gives a command, by message.
    pub fn command(&mut self, command: ModeCommand) {
        self.act(OperatorAction::Command(command));
    }

    /// Gives a command and waits for the answer: obeyed, or refused in words. No answer is a refusal too.
    pub fn ask(&mut self, command: ModeCommand) -> Result<(), String> {
        let before = self.answered();
        self.command(command);
        let end = self.now() + Duration::from_secs(1);
        while self.answered() == before {
            if self.next_event() > end {
                return Err(format!("{}: no answer", command.name()));
            }
            self.step();
        }
        self.refusal(before).map_or(Ok(()), Err)
    }

    /// Gives a command that must be obeyed.
    pub fn order(&mut self, command: ModeCommand) {
        if let Err(refusal) = self.ask(command) {
            self.give_up(&format!("should have been obeyed: {refusal}"));
        }
    }

    /// Turns the selector of a station.
    pub fn selector(&mut self, station: &str, manual: bool) {
        self.act(OperatorAction::Selector(self.id(station), manual));
    }

    /// Presses a panel button and keeps it down.
    pub fn press(&mut self, station: StationId, advance: bool) {
        self.act(OperatorAction::Panel { station, advance, down: true });
    }

    /// Lets go of a panel button.
    pub fn release(&mut self, station: StationId, advance: bool) {
        self.act(OperatorAction::Panel { station, advance, down: false });
    }

    /// Holds exactly these hand-mode buttons of the main console, by message.
    pub fn hold_buttons(&mut self, held: u32) {
        self.act(OperatorAction::Buttons(held));
    }

    /// Holds exactly this hand-mode button.
    pub fn hold_button(&mut self, button: ButtonId) {
        self.hold_buttons(1 << button.0);
    }

    /// Lets go of every hand-mode button.
    pub fn release_buttons(&mut self) {
        self.hold_buttons(0);
    }

    /// Holds a wired input of a station or the console, or lets go of it.
    pub fn wire(&mut self, owner: Owner, input: &str, value: Option<bool>) {
        let (station, names) = match owner {
            Owner::Station(id) => (Some(id), &self.line().station(id).inputs),
            Owner::Console => (None, &self.line().console.inputs),
        };
        let at = names.iter().position(|name| name == input).unwrap_or_else(|| panic!("no input {input}"));
        self.act(OperatorAction::Force(station, InputId::at(at), value));
    }

    /// Runs until something holds.
    ///
    /// # Panics
    /// When it does not within a minute of the line's time.
    pub fn run_until(&mut self, what: &str, holds: impl Fn(&WatchedLine) -> bool) {
        if !self.wait_for(PATIENCE, holds) {
            self.give_up(&format!("waited in vain: {what}"));
        }
    }

    /// Runs until something holds, but no longer than this. Gives whether it holds.
    pub fn wait_for(&mut self, time: Duration, holds: impl Fn(&WatchedLine) -> bool) -> bool {
        let end = self.now() + time;
        while !holds(self) {
            if self.next_event() > end {
                self.run_to(end);
                return false;
            }
            self.step();
        }
        true
    }

    /// Waits until all nodes are received, then gives start.
    pub fn start(&mut self) {
        self.run_until("everything is heard", |s| s.all_heard() && s.hears_console());
        // The coordinator receives the devices' state a moment later.
        self.run_for(Duration::from_millis(300));
        self.order(ModeCommand::Start);
    }

    /// Waits until all nodes are received, then gives start and auto.
    pub fn start_auto(&mut self) {
        self.start();
        self.order(ModeCommand::Auto);
    }

    /// Every station is running, received by the coordinator, and its devices are valid.
    pub fn all_heard(&self) -> bool {
        self.line().station_ids().all(|id| self.hears(id))
    }

    /// The console's device is in order.
    fn hears_console(&self) -> bool {
        self.coordinator().is_some() && self.trouble_of(Owner::Console).is_empty()
    }

    /// Holds a panel button until the operation under way ends, one way or another, then lets go.
    /// Gives whether anything moved.
    pub fn jog(&mut self, station: &str, advance: bool) -> bool {
        let id = self.id(station);
        let before = self.marking(id);
        self.press(id, advance);
        let moved = self.wait_for(Duration::from_millis(800), |s| s.marking(id) != before);
        if moved {
            let settled = |s: &WatchedLine| s.controller(id).is_some_and(|c| !c.marking().any(|p| p.is_operating()));
            self.wait_for(Duration::from_secs(5), settled);
        }
        self.release(id, advance);
        self.run_for(Duration::from_millis(100));
        moved
    }

    /// Waits until nothing moves and enters manual for every panel.
    pub fn go_manual(&mut self) {
        self.run_until("everything stands", |s| s.line().station_ids().all(|id| s.is_stopped(id)));
        // The coordinator receives it a moment later.
        for _ in 0..20 {
            match self.ask(ModeCommand::Manual) {
                Ok(()) => break,
                Err(_) => self.run_for(Duration::from_millis(100)),
            }
        }
        self.run_until("manual", |s| s.line().station_ids().all(|id| s.mode_of(id) == Some(ControlMode::Manual)));
    }

    /// Brings an incomplete station to a completed operation by advancing: resumes what was stopped.
    pub fn resume(&mut self, station: &str) {
        let id = self.id(station);
        if !self.jog(station, true) || self.is_incomplete(station) {
            self.give_up(&format!("{station} does not resume: {:?}", self.blocked_by(id)));
        }
    }

    /// In manual, leads every station home: forward where that goes, back where it does not, and again, since one may wait
    /// for another to be out of the way.
    pub fn lead_home(&mut self) {
        let mut back = vec![false; self.line().stations.len()];
        for _ in 0..60 {
            let is_home = |id: &StationId| self.controller(*id).is_some_and(|c| c.is_at_home());
            let away: Vec<StationId> = self.line().station_ids().filter(|id| !is_home(id)).collect();
            if away.is_empty() {
                return;
            }
            for id in away {
                let name = self.line().station(id).name.clone();
                if !self.jog(&name, !back[id.index()]) {
                    back[id.index()] = !back[id.index()];
                }
            }
        }
        let why: Vec<_> = self.line().station_ids().map(|id| (self.marking(id), self.blocked_by(id))).collect();
        self.give_up(&format!("not all are home: {why:?}"));
    }

    /// Whether the counts of all stations may be compared.
    pub fn has_common_start(&self) -> bool {
        let mut generations = self.line().station_ids().map(|id| self.controller(id).map_or(0, |c| c.generation()));
        let first = generations.next().unwrap_or(0);
        first != 0 && generations.all(|generation| generation == first)
    }

    /// Out of manual into auto, once the coordinator agrees.
    pub fn back_to_auto(&mut self) {
        let mut refusal = String::new();
        for _ in 0..10 {
            match self.ask(ModeCommand::Auto) {
                Ok(()) => return,
                Err(text) => refusal = text,
            }
            self.run_for(Duration::from_millis(100));
        }
        self.give_up(&format!("auto should have been obeyed: {refusal}"));
    }

    /// Runs until an operation has been completed in this cycle.
    pub fn run_until_done(&mut self, station: &str, operation: &str, cycle: i32) {
        let (id, op) = self.op(station, operation);
        let what = format!("{station}: {operation} done in cycle {cycle}");
        self.run_until(&what, |s| s.done(id, op) >= cycle);
    }

    /// After anything that put the line into stand-by or into the emergency stop: waits until all nodes are received,
    /// leads incomplete operations on, and orders auto again.
    pub fn bring_back(&mut self) {
        self.run_until("everything is heard", WatchedLine::all_heard);
        self.settle();
        if self.mode() == Some(ControlMode::Auto) {
            return;
        }
        if self.mode() == Some(ControlMode::EStop) {
            self.order(ModeCommand::Reset);
        }
        if self.mode() == Some(ControlMode::Home) {
            self.order(ModeCommand::Start);
        }
        self.go_manual();
        let stations: Vec<String> = self.line().stations.iter().map(|station| station.name.clone()).collect();
        for station in stations {
            if self.is_incomplete(&station) {
                self.resume(&station);
            }
        }
        self.back_to_auto();
    }

    /// So many messages in a row may be lost that a node is silent for too long, or that no image of a motion arrives
    /// before its end: the line then falls to stand-by, as it should, and its operator brings it back.
    pub fn patiently_until_done(&mut self, station: &str, operation: &str, cycle: i32) {
        let (id, op) = self.op(station, operation);
        for _ in 0..5 {
            self.run_until("it is done, or the line in stand-by", |s| {
                s.done(id, op) >= cycle || s.mode() == Some(ControlMode::StandBy)
            });
            if self.done(id, op) >= cycle {
                return;
            }
            self.bring_back();
        }
        panic!("{station}: {operation} is not done in cycle {cycle}");
    }
}
