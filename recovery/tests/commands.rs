//! The commands of a list as they are printed, given one after the other: each is accepted when it is the first of its list.

use std::time::Duration;

use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::ControlMode;
use linewright_line::{ButtonId, Line, RestId, StationId};
use linewright_recovery::{LineSituation, Need, RecoveryAction, RecoveryEnd, RecoveryStep, StandingAlarm, plan};
use linewright_simulation::{LineSim, OperatorAction};

use crate::cells::shipped;
use crate::operator::{command, described, run_for, situation, switched_on};

/// A machine of the workcell that stands clamped, and has no part: its next loading begins at the open rest.
struct WrongRest {
    sim: LineSim,
    station: StationId,
    wanted: RestId,
    is_answered: bool,
}

impl WrongRest {
    fn clamped(mode: ControlMode) -> Self {
        let [(_, line), _] = shipped();
        let station = line.station_named("m1").expect("it is one");
        let wanted = line.station(station).rest_named("open").expect("it is one");
        let mut sim = switched_on(&line, 1);
        let steps = line.station(station).steps.iter().flatten();
        let waits: Vec<_> = steps.flat_map(|&op| line.station(station).awaited_by(op)).collect();
        let force = |sim: &mut LineSim, on| {
            for &input in &waits {
                sim.act(OperatorAction::Force(Some(station), input, on)).expect("it is done");
            }
        };
        force(&mut sim, Some(true));
        command(&mut sim, ModeCommand::Start);
        command(&mut sim, ModeCommand::Hand);
        hold(&mut sim, &line, "PB_load_1", 20.0);
        force(&mut sim, None);
        // The robot has begun as well, and waits for a part: it is led to its rest.
        [ModeCommand::EStop, ModeCommand::Reset, ModeCommand::Manual].iter().for_each(|&of| command(&mut sim, of));
        let robot = line.station_named("robot").expect("it is one");
        for down in [true, false].repeat(4) {
            sim.act(OperatorAction::Panel { station: robot, advance: false, down }).expect("it is done");
            run_for(&mut sim, Duration::from_secs(5));
        }
        command(&mut sim, ModeCommand::Auto);
        let way: &[ModeCommand] = match mode {
            ControlMode::Home => &[ModeCommand::Stop],
            ControlMode::StandBy => &[ModeCommand::Stop, ModeCommand::Start],
            ControlMode::Hand => &[ModeCommand::Stop, ModeCommand::Start, ModeCommand::Hand],
            _ => &[],
        };
        way.iter().for_each(|&of| command(&mut sim, of));
        let found = WrongRest { sim, station, wanted, is_answered: false };
        assert_eq!(found.sim.mode(), mode, "{}", described(&found.sim));
        assert!(found.rest().is_some_and(|rest| rest != wanted), "{}", described(&found.sim));
        found
    }

    /// Another machine and the robot have been let go between two rests, with nothing incomplete.
    fn and_others_between_rests(mut self) -> Self {
        let line = self.sim.line().clone();
        let way: &[ModeCommand] = match self.sim.mode() {
            ControlMode::Home => &[ModeCommand::Start, ModeCommand::Hand],
            ControlMode::StandBy => &[ModeCommand::Hand],
            _ => &[],
        };
        way.iter().for_each(|&of| command(&mut self.sim, of));
        hold(&mut self.sim, &line, "PB_load_2", 20.0);
        command(&mut self.sim, ModeCommand::Stop);
        let report = |name: &str| {
            let id = line.station_named(name).expect("it is one");
            self.sim.controller(id).expect("it is up").report()
        };
        for report in [report("robot"), report("m2")] {
            assert!(!report.at_home && report.incomplete.is_empty(), "{}", described(&self.sim));
        }
        self
    }

    fn rest(&self) -> Option<RestId> {
        self.sim.controller(self.station)?.report().order?.rest
    }

    fn seen(&self) -> LineSituation {
        let mut seen = situation(&self.sim);
        if !self.is_answered {
            seen.left_out = vec![self.station];
            let bring = Some((self.station, self.wanted)).filter(|_| self.rest() != Some(self.wanted));
            let (text, answers) = ("m1 stands at rest \"clamped\".".to_owned(), vec![ListedAnswer::from("up")]);
            let (lead, reset, at_order) = (Vec::new(), Vec::new(), Vec::new());
            let alarm = StandingAlarm { id: 7, text, answers, lead, reset, at_order, end: None, bring };
            seen.alarms = vec![alarm];
        }
        seen
    }

    /// Gives a command as it is printed.
    fn give(&mut self, words: &[String]) {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let line = self.sim.line().clone();
        let answers = self.sim.answered();
        match words[..] {
            ["mode", "LINE", name, ..] => {
                command(&mut self.sim, ModeCommand::parse(name).expect("a command"));
                if words.last() == Some(&"--wait") {
                    run_for(&mut self.sim, Duration::from_secs(5));
                }
                assert_eq!(self.sim.refusal(answers), None, "{words:?}: {}", described(&self.sim));
            }
            ["press", "LINE", button, "--for", time] => {
                assert_eq!(self.sim.mode(), ControlMode::Hand, "{words:?}");
                hold(&mut self.sim, &line, button, time.parse().expect("seconds"));
            }
            ["press", "LINE", side, "--station", name, "--for", time] => {
                assert_eq!(self.sim.mode(), ControlMode::Manual, "{words:?}");
                let (station, advance) = (line.station_named(name).expect("it is one"), side == "advance");
                for down in [true, false] {
                    self.sim.act(OperatorAction::Panel { station, advance, down }).expect("it is done");
                    run_for(&mut self.sim, Duration::from_secs_f64(time.parse().expect("seconds")));
                }
            }
            // The coordinator takes it where the station stands at the rest where its next task begins.
            ["answer", "LINE", "7", "up"] => {
                assert_eq!(self.rest(), Some(self.wanted), "{words:?} is refused: {}", described(&self.sim));
                self.is_answered = true;
            }
            _ => panic!("{words:?}"),
        }
    }
}

fn hold(sim: &mut LineSim, line: &Line, button: &str, seconds: f64) {
    let at = line.buttons.iter().position(|name| name == button).expect("a button of the console");
    let button = ButtonId::at(at);
    sim.act(OperatorAction::Buttons(1 << button.0)).expect("it is done");
    run_for(sim, Duration::from_secs_f64(seconds));
    sim.act(OperatorAction::Buttons(0)).expect("it is done");
    run_for(sim, Duration::from_millis(600));
}

/// Gives the first command of each list until nothing is to be done.
fn follow_commands(mut of: WrongRest) {
    let (line, mode) = (of.sim.line().clone(), of.sim.mode());
    let mut given = Vec::new();
    for _ in 0..30 {
        let found = plan(&line, &of.seen());
        assert_eq!(found.end, RecoveryEnd::Auto, "{mode}: {}", described(&of.sim));
        let Some(step) = found.steps.first() else { break };
        let commands = step.commands(&line);
        assert!(!commands.is_empty(), "{mode}: {}: {}", step.text(&line), described(&of.sim));
        given.push(commands[0].join(" "));
        of.give(&commands[0]);
    }
    assert!(of.is_answered && of.sim.mode() == ControlMode::Auto, "{mode}: {given:#?}");
    // PB_back_1 leads there as well, with as many motions; its alarm names this one.
    assert!(given.iter().any(|words| words.starts_with("press LINE PB_clear_1 ")), "{mode}: {given:#?}");
}

#[test]
fn each_command_to_a_station_at_the_wrong_rest_is_accepted_as_it_is_printed() {
    for mode in [ControlMode::Auto, ControlMode::Home, ControlMode::StandBy, ControlMode::Hand] {
        follow_commands(WrongRest::clamped(mode));
    }
}

/// The others are led to rests in manual, then the first one in hand mode.
#[test]
fn so_is_each_where_other_stations_stand_between_two_rests() {
    for mode in [ControlMode::Home, ControlMode::StandBy, ControlMode::Hand] {
        let of = WrongRest::clamped(mode).and_others_between_rests();
        let line = of.sim.line().clone();
        let steps = plan(&line, &of.seen()).steps;
        let texts: Vec<String> = steps.iter().map(|step| step.text(&line)).collect();
        assert!(steps.iter().all(|step| !step.commands(&line).is_empty()), "{texts:#?}");
        follow_commands(of);
    }
}

/// Where no button leads there, the answer is not the first of the list.
#[test]
fn an_answer_that_would_be_refused_does_not_stand_first() {
    let of = WrongRest::clamped(ControlMode::Auto);
    let mut line = of.sim.line().clone();
    line.buttons.clear();
    let steps = plan(&line, &of.seen()).steps;
    let at = |is_it: &dyn Fn(&RecoveryStep) -> bool| steps.iter().position(is_it);
    let bring = at(&|step| matches!(step.action, RecoveryAction::First(Need::Bring(..))));
    let answer = at(&|step| matches!(step.action, RecoveryAction::First(Need::Answer(_))));
    assert!(bring.is_some() && bring < answer, "{steps:#?}");
}
