//! The mode's text read back, by what a plan needs of it.
//!
//! The state of the line has the mode as a number and everything that keeps it as a text. These are the few parts of the text
//! that a plan depends on. A test writes them as the coordinator does, and reads them.

use linewright_coordinator_logic::{EStopButton, ModeRefusal};
use linewright_line::{Line, StationId};

const NOT_RESET: &str = ", not reset;";
const STOPPING: &str = "stopping at home";
const LEFT_OUT: &str = ", without ";
const ENDED: &str = " ended (";
const SECOND_COORDINATOR: &str = "second coordinator active";

/// What the text of the mode says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModeRead {
    /// Master stop was given.
    pub is_stopping: bool,
    /// The emergency stop has been reset, or there is none.
    pub is_reset: bool,
    /// The console's emergency stop button is pressed.
    pub is_pressed: bool,
    /// The console's devices are not operational, or were not received yet.
    pub without_console: bool,
    pub restarted: Vec<StationId>,
    /// Stations that are left out of the mode decision.
    pub left_out: Vec<StationId>,
    /// A second coordinator or a journal that cannot be written, in words.
    pub obstacles: Vec<String>,
}

impl ModeRead {
    /// Reads a text that the coordinator has written for this line.
    pub fn of(line: &Line, text: &str) -> Self {
        // A station's name may be the end of another one's.
        let says = |text: &str, reason: &ModeRefusal| {
            let before = |(at, _): (usize, &str)| text[..at].chars().next_back();
            text.match_indices(&reason.text(line)).map(before).any(|letter| matches!(letter, None | Some(' ' | '(')))
        };
        let restarted = line.station_ids().filter(|&id| says(text, &ModeRefusal::Restarted(id))).collect();
        // What has ended a mode may be over; what stands against another one is among the troubles.
        let standing = without_ended(text);
        let text = standing.as_str();
        let (_, without) = text.split_once(LEFT_OUT).unwrap_or_default();
        let names = without.split([',', ':']).map(str::trim).map_while(|name| line.station_named(name));
        let mut obstacles: Vec<String> =
            text.split("; ").filter_map(|part| part.find(SECOND_COORDINATOR).map(|at| part[at..].to_owned())).collect();
        let journal = ModeRefusal::JournalLost;
        obstacles.extend(says(text, &journal).then(|| journal.text(line)));
        ModeRead {
            is_stopping: text.contains(STOPPING),
            is_reset: !text.contains(NOT_RESET),
            is_pressed: text.contains(EStopButton::RELEASE_IT),
            without_console: says(text, &ModeRefusal::ConsoleLost) || says(text, &ModeRefusal::ConsoleNeverHeard),
            restarted,
            left_out: names.collect(),
            obstacles,
        }
    }
}

/// The text without the mode that ended by itself and its reasons, in which there may be parentheses.
fn without_ended(text: &str) -> String {
    let Some((before, reasons)) = text.split_once(ENDED) else { return text.to_owned() };
    let before = before.rsplit_once(", ").map_or(before, |(before, _mode)| before);
    let mut open = 1;
    let end = reasons.char_indices().find(|&(_, letter)| {
        open += i32::from(letter == '(') - i32::from(letter == ')');
        open == 0
    });
    let after = end.map_or("", |(at, _)| &reasons[at + 1..]);
    format!("{before}{after}")
}

#[cfg(test)]
mod tests {
    use linewright_coordinator_logic::{EStopCause, ModeText};
    use linewright_line::net::ControlMode;
    use linewright_line::{InputId, TransferLine};

    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let names: Vec<&str> = line.stations.iter().map(|station| station.name.as_str()).collect();
        let read = |mode, text: &ModeText<'_>| ModeRead::of(&line, &text.text(mode));
        assert_eq!(
            read(ControlMode::StandBy, &ModeText::default()),
            ModeRead { is_reset: true, ..ModeRead::default() }
        );
        let reasons = [
            ModeRefusal::NotHeard(StationId(0)),
            ModeRefusal::Restarted(StationId(2)),
            ModeRefusal::JournalLost,
            ModeRefusal::OtherCoordinator(7),
            ModeRefusal::ConsoleNeverHeard,
        ];
        let text = ModeText {
            stop: Some(EStopCause::Pressed(InputId(0)).text(&line)),
            button: EStopButton::Pressed,
            stopped_at: "2026-11-23",
            without: vec![names[1], names[2]],
            stopped: vec![names[0]],
            troubles: reasons.iter().map(|reason| reason.text(&line)).collect(),
            ..ModeText::default()
        };
        let found = read(ControlMode::EStop, &text);
        assert!(!found.is_reset && found.is_pressed && found.without_console, "{found:?}");
        assert_eq!(found.restarted, [StationId(2)]);
        assert_eq!(found.left_out, [StationId(1), StationId(2)]);
        assert_eq!(found.obstacles.len(), 2, "{found:?}");
        assert!(found.obstacles[0].contains("boot id 7"), "{found:?}");
        let stopping = ModeText { stopping: true, ..ModeText::default() };
        assert!(read(ControlMode::Auto, &stopping).is_stopping && !found.is_stopping);
        let released = read(ControlMode::EStop, &ModeText { button: EStopButton::Released, ..text.clone() });
        assert!(!released.is_reset && !released.is_pressed, "{released:?}");
        assert!(read(ControlMode::EStop, &ModeText { stop: None, ..text }).is_reset);
    }

    #[test]
    fn what_has_ended_a_mode_does_not_stand_against_the_next_one() {
        let line = linewright_line::parse("line.toml", &TransferLine::default().text()).expect("parses").line;
        let past = [ModeRefusal::OtherCoordinator(7), ModeRefusal::ConsoleLost, ModeRefusal::Restarted(StationId(1))];
        let ended = ModeText {
            ended: Some((ControlMode::Auto, past.iter().map(|reason| reason.text(&line)).collect())),
            ..ModeText::default()
        };
        let found = ModeRead::of(&line, &ended.text(ControlMode::StandBy));
        let restarted = vec![StationId(1)];
        assert_eq!(found, ModeRead { is_reset: true, restarted: restarted.clone(), ..ModeRead::default() });
        // The same while it lasts.
        let stands = ModeText { troubles: vec![ModeRefusal::ConsoleLost.text(&line)], ..ended };
        let found = ModeRead::of(&line, &stands.text(ControlMode::StandBy));
        assert_eq!(found, ModeRead { is_reset: true, restarted, without_console: true, ..ModeRead::default() });
    }
}
