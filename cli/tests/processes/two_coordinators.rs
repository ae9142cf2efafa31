//! Two coordinators of one line.
//!
//! ```text
//!   auto ── a second coordinator is started ──▶ it ends: it came second                      auto goes on
//!   auto ── another one that does not end ──▶ stand-by, nothing moves, all nodes name it
//!        ── the emergency stop of the other ──▶ every station in it ── the other one ends ──▶ recovered ──▶ auto
//! ```

use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use linewright_msgs::{ModeOrder, StationState};
use linewright_node_shell::{Participant, RosArgs, RosNode, qos};

use crate::support::operator::Operator;
use crate::support::rig::{OWN_BUS, Rig, line, send_signal};
use crate::support::{PATIENCE, pause, wait_for};

const OTHER: u64 = 4711;
const ENDS: u8 = u8::MAX;

/// A coordinator that gives orders whatever it receives. It ends when dropped.
struct Other {
    mode: Arc<AtomicU8>,
    thread: Option<JoinHandle<()>>,
    _node: RosNode,
    _participant: Participant,
}

impl Other {
    /// It orders auto, as if every station had acknowledged that, of these boot ids.
    fn start(rig: &Rig, lives: Vec<u64>) -> Self {
        let participant = Participant::open(&RosArgs { domain_id: rig.domain(), ..RosArgs::default() }).expect("joins");
        let mut node = participant.node("/transfer_line", "other").expect("a node");
        let orders = node.publisher("mode", qos::command()).expect("a topic");
        let mode = Arc::new(AtomicU8::new(StationState::MODE_AUTO));
        let is = mode.clone();
        let thread = std::thread::spawn(move || {
            for sequence in 1.. {
                let mode = is.load(Ordering::Relaxed);
                if mode == ENDS {
                    break;
                }
                let order =
                    ModeOrder { boot_id: OTHER, sequence, epoch: 1, mode, lease_ms: 500, ..ModeOrder::default() };
                orders.send(ModeOrder { enabled: true, lives: lives.clone(), ..order });
                std::thread::sleep(Duration::from_millis(50));
            }
        });
        Other { mode, thread: Some(thread), _node: node, _participant: participant }
    }

    fn orders(&self, mode: u8) {
        self.mode.store(mode, Ordering::Relaxed);
    }
}

impl Drop for Other {
    fn drop(&mut self) {
        self.orders(ENDS);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[test]
fn a_second_coordinator_ends_and_one_that_does_not_stops_the_line() {
    // The mill drives its devices itself, the others are behind the gateway.
    let own = format!("name = \"mill_1\"\nbus = \"{OWN_BUS}\"\n");
    let mut rig = Rig::new(&line(1.0).replacen("name = \"mill_1\"\n", &own, 1));
    let operator = rig.in_auto();
    a_second_coordinator_ends_and_names_the_first(&rig, &operator);
    // It may have ended before the first one received anything of it.
    // On a busy machine a station may be unheard for a moment, which does not end auto.
    if !wait_for(Duration::from_secs(1), || operator.heard().in_mode(StationState::MODE_AUTO)) {
        operator.recover();
    }
    operator.cycles(1);

    rig.eye.wait("something moves", |seen| !seen.energised().is_empty());
    let other = Other::start(&rig, operator.heard().boot_ids().split_off(1));
    nothing_moves(&rig, &operator);
    other.orders(StationState::MODE_ESTOP);
    operator.wait("e-stop", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
    operator.wait("of the line", |heard| heard.line.mode == StationState::MODE_ESTOP);
    drop(other);
    operator.wait("one is left", |heard| heard.all(|state| state.blocked_by.iter().all(|why| !is_named(why))));
    // The stop of the other one counts as given until it has been silent for its term.
    pause(1500);
    operator.say("reset");
    operator.recover();
    operator.cycles(1);
    operator.go_home();
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

fn a_second_coordinator_ends_and_names_the_first(rig: &Rig, operator: &Operator) {
    let first = operator.heard().line.boot_id;
    // Another node name and another bus, so that the claims on this machine do not refuse it.
    let more = ["--bus", "rig-second", "--virtual-bus", "--ros-args", "-r", "__node:=second"];
    let mut command = rig.command(&["coordinator"], &more);
    let mut second = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts");
    let ended = wait_for(PATIENCE, || second.try_wait().expect("a child").is_some());
    if !ended {
        send_signal("KILL", second.id());
    }
    let output = second.wait_with_output().expect("a child");
    let text = String::from_utf8_lossy(&output.stderr);
    let text: String = text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
    assert!(ended && output.status.code() == Some(1), "{text}");
    let expected = format!("second coordinator: one with boot id {first} is active on this line; this one ends");
    assert!(text.contains(&expected), "{text}");
    // The text still has it once, as the reason why auto ended; as long as it is there, twice.
    operator.wait("the first one is alone", |heard| heard.line.text.matches("second coordinator").count() < 2);
}

fn is_named(reason: &str) -> bool {
    reason.contains("one coordinator: two are active") && reason.contains(&OTHER.to_string())
}

fn nothing_moves(rig: &Rig, operator: &Operator) {
    operator.wait("every station says why", |heard| {
        heard.all(|state| state.mode == StationState::MODE_STANDBY && state.blocked_by.iter().any(|why| is_named(why)))
    });
    let named = format!("second coordinator active on this line (boot id {OTHER})");
    operator.wait("the coordinator as well", |heard| heard.line.text.contains(&named));
    operator.wait("everything stands", |heard| heard.all(|state| state.stopped));
    let started = rig.eye.seen().starts().len();
    for command in ["auto", "manual"] {
        let refusal = operator.refused(command);
        assert!(refusal.contains(&named), "{refusal}");
    }
    pause(700);
    assert_eq!(&rig.eye.seen().starts()[started..], []);
}
