//! A table with a bolt, turned by a drive that is homed by its index: switched on, the drive says nothing.

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, parse};
use linewright_station_logic::Restore;

use super::rig::Rig;

const BOLT: &str = r#"[[station.operation]]
name = "NAME"
module = "R"
moves = { axis = "bolt", FROM_TO }
duration_s = 0.2
watchdog_s = 1.0
normal = { actuator = "ON", complete = "AT" }
recovery = { actuator = "OFF", complete = "BACK" }
hand = { type = 6, forward = "PB_index", back = "PB_back", next = "PB_index" }

"#;

fn line() -> Line {
    let bolt = |words: [&str; 6]| {
        let keys = ["NAME", "FROM_TO", "ON", "AT", "OFF", "BACK"];
        keys.iter().zip(words).fold(BOLT.to_owned(), |text, (key, word)| text.replace(key, word))
    };
    let unlock = bolt(["unlock", "from = 0, to = 10", "pull", "LS_free", "push", "LS_locked"]);
    let lock = bolt(["lock", "from = 10, to = 0", "push", "LS_locked", "pull", "LS_free"]);
    let homing = "at_rest = \"hold\"\nhoming = { method = 17, fast = 20, slow = 2, output = \"turn\" }";
    let text = include_str!("../../../../examples/driven-table.toml")
        .replace("home = \"index\"\naxes = { table = 0.0 }", "home = \"lock\"\naxes = { table = 0.0, bolt = 0 }")
        .replace("[[station.operation]]\nname = \"index\"", &format!("{unlock}[[station.operation]]\nname = \"index\""))
        .replace("[[station]]\nname = \"load\"", &format!("{lock}[[station]]\nname = \"load\""))
        .replace(
            "\"PB_return\"]\noutputs = [\"lamp_table\"]",
            "\"PB_return\", \"LS_free\", \"LS_locked\"]\noutputs = [\"lamp_table\", \"pull\", \"push\"]",
        )
        .replace("at_rest = \"hold\"", homing)
        .replace("from = \"table: index\"", "from = \"table: lock\"")
        .replace("to = \"table: index\"", "to = \"table: unlock\"")
        .replace("from = \"index\", until = \"index\"", "from = \"unlock\", until = \"lock\"");
    parse("bolted.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

struct Table {
    rig: Rig,
}

impl Table {
    fn up(restore: Restore, on: &[&str]) -> Self {
        let line = line();
        let names = line.stations[0].inputs.clone();
        let image = names.iter().enumerate().filter(|(_, name)| on.contains(&name.as_str()));
        let image = image.fold(0, |bits, (bit, _)| bits | 1 << bit);
        let mut rig = Rig::alone(line, StationId(0), restore, image);
        rig.refresh();
        Table { rig }
    }

    fn see(&mut self, off: &[&str], on: &[&str]) {
        let names = self.rig.line.stations[0].inputs.clone();
        let bits = |of: &[&str]| {
            let all = names.iter().enumerate().filter(|(_, name)| of.contains(&name.as_str()));
            all.fold(0, |bits, (bit, _)| bits | 1u128 << bit)
        };
        self.rig.set(bits(off), false);
        self.rig.set(bits(on), true);
    }

    fn outputs(&self) -> Vec<&str> {
        let names = self.rig.line.stations[0].outputs.iter().enumerate();
        names.filter(|(bit, _)| self.rig.outputs & (1 << bit) != 0).map(|(_, name)| name.as_str()).collect()
    }

    fn advance(&mut self) {
        self.rig.advance(false);
        self.rig.advance(true);
    }

    fn is_lost(&self) -> bool {
        self.rig.controller.position_lost().is_some()
    }
}

#[test]
fn switched_on_with_the_bolt_home_a_person_draws_it_homes_the_drive_and_locks_again() {
    let mut table = Table::up(Restore::Fresh, &["LS_locked"]);
    for mode in [ControlMode::Auto, ControlMode::Hand] {
        table.rig.mode(mode);
        table.rig.wait_ms(200);
        assert_eq!((table.outputs(), table.is_lost()), (vec![], true), "not by itself");
    }
    table.rig.mode(ControlMode::Manual);
    let waits = table.rig.blocked_by().join("\n");
    assert!(waits.contains("the homing of its drive: hold advance at its panel in manual"), "{waits}");
    assert!(table.rig.fault().contains("the homing of its drive"), "{}", table.rig.fault());
    table.advance();
    assert_eq!(table.outputs(), ["pull"]);
    table.rig.advance(false);
    assert_eq!(table.outputs(), Vec::<&str>::new(), "while it is held, and no longer");
    table.advance();
    table.see(&["LS_locked"], &["LS_free"]);
    assert_eq!(table.rig.doing(), "unlock (done)");
    table.advance();
    assert_eq!(table.outputs(), ["turn"], "to no place: that homes it");
    assert_eq!(table.rig.doing(), "unlock (done) + homing");
    table.see(&[], &["in_place", "place_1"]);
    assert_eq!((table.rig.doing().as_str(), table.is_lost()), ("unlock (done)", false), "a homing is no index");
    table.advance();
    assert_eq!(table.outputs(), ["turn", "to_2"]);
    table.see(&["in_place"], &[]);
    table.see(&["place_1"], &["in_place", "place_2"]);
    table.advance();
    assert_eq!(table.outputs(), ["push"]);
    table.see(&["LS_free"], &["LS_locked"]);
    assert_eq!((table.rig.doing().as_str(), table.rig.fault().as_str()), ("lock (done)", ""));
    assert!(table.rig.report().at_home);
    table.rig.mode(ControlMode::Auto);
    assert_eq!(table.outputs(), ["pull"]);
}

/// Where a table stands that is not homed nothing says.
#[test]
fn nothing_locks_a_table_whose_drive_is_not_homed() {
    let mut table = Table::up(Restore::Fresh, &["LS_locked", "in_place", "place_1"]);
    table.rig.mode(ControlMode::Auto);
    table.see(&["LS_locked"], &["LS_free"]);
    table.see(&["in_place"], &[]);
    table.see(&["place_1"], &["in_place", "place_2"]);
    assert_eq!(table.outputs(), ["push"]);
    let kept = table.rig.controller.snapshot();
    let mut again = Table::up(Restore::From(kept), &["LS_free"]);
    again.rig.mode(ControlMode::Manual);
    for _ in 0..3 {
        again.advance();
        assert_eq!(again.outputs(), Vec::<&str>::new(), "{}", again.rig.doing());
    }
    again.rig.advance(false);
    // The person names what leads on to the index.
    let waits = again.rig.blocked_by().join("\n");
    assert!(waits.contains("possible: `unlock`, `index`"), "{waits}");
    let unlock = again.rig.line.stations[0].operation_named("unlock");
    assert!(again.rig.rejoin(unlock).is_taken());
    again.advance();
    assert_eq!(again.outputs(), ["turn"]);
}

/// Homed, it is compared with the place of the record.
#[test]
fn turned_while_it_was_off_it_is_in_doubt_once_it_is_homed() {
    let before = Table::up(Restore::Fresh, &["LS_locked", "in_place", "place_2"]);
    let kept = before.rig.controller.snapshot();
    assert_eq!(kept.place, 2);
    let mut table = Table::up(Restore::From(kept), &["LS_locked"]);
    assert!(table.is_lost() && !table.rig.is_doubtful());
    table.see(&[], &["in_place", "place_1"]);
    assert!(table.rig.is_doubtful());
}
