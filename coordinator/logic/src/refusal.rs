//! Refusals: a command that is not obeyed is answered with every reason, never kept for later.

use linewright_line::net::ControlMode;
use linewright_line::{Line, Owner, StationId};

use crate::decision::ModeCommand;

/// Why a command is not obeyed now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModeRefusal {
    /// The mode has no use for it; these commands it would take.
    WrongMode(Vec<ModeCommand>),
    /// The line is already in that mode.
    Already,
    /// The emergency stop is latched.
    EStop,
    /// The emergency stop button is still pressed.
    EStopPressed,
    /// The console's devices are not heard.
    ConsoleLost,
    /// The coordinator's journal cannot be written.
    JournalLost,
    /// Another coordinator gives orders to this line; its boot id.
    OtherCoordinator(u64),
    /// The console's devices have not been heard since the coordinator came up.
    ConsoleNeverHeard,
    NotHeard(StationId),
    DevicesLost(StationId),
    /// A station has an operation that was stopped before its end.
    Incomplete(StationId),
    /// A mechanism of a station is not measured where its chart has it.
    PositionLost(StationId),
    /// A station has no memory of counts that the others share.
    NoCommonStart(StationId),
    /// A station was restarted and has not been looked at since.
    Restarted(StationId),
    /// A station's selector stands at manual.
    SelectorManual(StationId),
    /// A station is still moving.
    Moving(StationId),
    /// A station stands, and has not acknowledged yet that it is to.
    Unaware(StationId),
    NotAtHome(StationId),
    /// A station is at home, but a round behind another.
    Behind(StationId),
}

/// A command that was not obeyed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedCommand {
    pub command: ModeCommand,
    /// The mode that refused it.
    pub mode: ControlMode,
    /// All reasons, at least one.
    pub reasons: Vec<ModeRefusal>,
}

impl RefusedCommand {
    /// The refusal in words, e.g. `auto refused in stand-by: mill_1 has an incomplete operation: recover it in manual`.
    pub fn text(&self, line: &Line) -> String {
        self.text_with(line, |_| String::new())
    }

    /// The same, with what is wrong with the devices of whoever has lost them (empty where nobody knows).
    pub fn text_with(&self, line: &Line, trouble: impl Fn(Owner) -> String) -> String {
        let in_words = |reason: &ModeRefusal| {
            let trouble = match reason {
                ModeRefusal::DevicesLost(station) => trouble(Owner::Station(*station)),
                ModeRefusal::ConsoleLost | ModeRefusal::ConsoleNeverHeard => trouble(Owner::Console),
                _ => String::new(),
            };
            let text = reason.text(line);
            if trouble.is_empty() { text } else { format!("{text}: {trouble}") }
        };
        let reasons: Vec<String> = self.reasons.iter().map(in_words).collect();
        format!("{} refused in {}: {}", self.command.name(), self.mode, reasons.join("; "))
    }
}

impl ModeRefusal {
    /// The reason in words.
    pub fn text(&self, line: &Line) -> String {
        let name = |station: &StationId| line.station(*station).name.as_str();
        match self {
            ModeRefusal::WrongMode(takes) => {
                let takes: Vec<&str> = takes.iter().map(|command| command.name()).collect();
                format!("this mode takes {}", takes.join(", "))
            }
            ModeRefusal::Already => "the line is in that mode already".to_owned(),
            ModeRefusal::EStop => "the emergency stop is on: reset it, then only manual leads out".to_owned(),
            ModeRefusal::EStopPressed => "the emergency stop button is pressed: pull it out first".to_owned(),
            ModeRefusal::ConsoleLost => "the console's devices are not heard".to_owned(),
            ModeRefusal::JournalLost => {
                "the coordinator cannot write its journal (its log names file and cause): put that right, then reset"
                    .to_owned()
            }
            ModeRefusal::OtherCoordinator(life) => {
                format!("another coordinator (boot id {life}) gives orders to this line: end one of the two")
            }
            ModeRefusal::ConsoleNeverHeard => {
                "the console has not been heard yet, so its emergency stop may be pressed: see to its device's supply and bus"
                    .to_owned()
            }
            ModeRefusal::NotHeard(s) => format!("{} is not heard", name(s)),
            ModeRefusal::DevicesLost(s) => format!("{} has lost its devices", name(s)),
            ModeRefusal::Incomplete(s) => format!("{} has an incomplete operation: recover it in manual", name(s)),
            ModeRefusal::PositionLost(s) => {
                format!(
                    "{} is not measured where its chart has it: see its fault, look at the mechanism and the switch",
                    name(s)
                )
            }
            ModeRefusal::NoCommonStart(s) => format!(
                "{} has no memory of the counts the others share: lead all stations home in manual, then give auto",
                name(s)
            ),
            ModeRefusal::Restarted(s) => format!("{} was restarted: give start or go through manual first", name(s)),
            ModeRefusal::SelectorManual(s) => format!("the selector of {} stands at manual", name(s)),
            ModeRefusal::Moving(s) => format!("{} is still moving", name(s)),
            ModeRefusal::Unaware(s) => format!("{} has not acknowledged stand-by yet", name(s)),
            ModeRefusal::NotAtHome(s) => format!("{} is not at home", name(s)),
            ModeRefusal::Behind(s) => format!("{} is at home, but a cycle behind: give auto and then stop", name(s)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_line::TransferLine;

    #[test]
    fn a_loss_is_refused_with_the_device_and_its_trouble_where_it_is_known() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let reasons =
            vec![ModeRefusal::DevicesLost(StationId(1)), ModeRefusal::ConsoleLost, ModeRefusal::Moving(StationId(0))];
        let refusal = RefusedCommand { command: ModeCommand::Auto, mode: ControlMode::StandBy, reasons };
        let known = |owner| match owner {
            Owner::Station(_) => "clamp 1 io (node 21h): no heartbeat (1017h) for 230 ms".to_owned(),
            Owner::Console => String::new(),
        };
        let expected = "auto refused in stand-by: clamp_1 has lost its devices: clamp 1 io (node 21h): no heartbeat \
                        (1017h) for 230 ms; the console's devices are not heard; transfer is still moving";
        assert_eq!(refusal.text_with(&line, known), expected);
    }
}
