//! A cell operated from a page of the console alone: an order, the robot without its part, the alarm, its acknowledgement and its answer,
//! and the order finished.
//!
//! ```text
//!   this test, as a page ── WebSocket ──▶ linewright console ── ROS services ──▶ coordinator of the cell
//! ```

use linewright_console_view::{PageAct, ResourceCommand};
use serde_json::Value;

use super::cells::{LONG, cell};
use super::console::{PageOfConsole, console, is_mode};
use crate::support::rig::{BUS, send_signal};
use crate::support::wait_for;

fn alarm(page: &Value) -> Option<&Value> {
    page["alarms"].as_array()?.iter().find(|alarm| !alarm["number"].is_null())
}

fn order<'p>(page: &'p Value, name: &str) -> Option<&'p Value> {
    page["cell"]["orders"].as_array()?.iter().find(|order| order["name"] == name)
}

#[test]
fn an_order_is_submitted_goes_wrong_is_answered_and_is_finished_at_a_page() {
    let mut rig = cell("workcell-c1", 8.0);
    rig.start(&["--no-auto"]);
    let (mut process, address) = console(&rig);
    let mut page = PageOfConsole::open(&address);
    page.wait("home", is_mode("home"));
    page.wait("the cell", |page| page["cell"]["products"].as_array().is_some_and(|all| !all.is_empty()));
    page.take_control();
    page.command("start", "stand-by");
    page.command("auto", "auto");
    let gripper = |what| rig.said(&["fail"], &["robot", what, "--operation", "grasp for m1", "--bus", BUS]).is_ok();
    assert!(wait_for(LONG, || gripper("miss")), "the gripper can be made to miss");

    let submit = |product: &str| PageAct::Submit {
        product: product.to_owned(),
        quantity: 1,
        name: "rush".to_owned(),
        due_s: Some(600),
    };
    page.give(submit("no product of it"));
    page.wait_note("no product `no product of it`");
    page.give(submit("A"));
    page.wait_note("production order 1: `rush`");
    let shown = page.wait("the order", |page| order(page, "rush").is_some());
    assert!(order(&shown, "rush").is_some_and(|of| of["due"].as_str().is_some_and(|due| due.starts_with("due in "))));
    page.give(submit("A"));
    // Of orders that are not over each has a name of its own.
    page.wait_note("order name `rush` in use");

    let shown = page.wait("the alarm", |page| alarm(page).is_some());
    let of = alarm(&shown).expect("it is there");
    assert!(of["text"].as_str().is_some_and(|text| text.starts_with("R grasped no part at slot 1 of ST")), "{of:#}");
    assert_eq!(of["state"], "active, not acknowledged");
    let (number, id) = (of["number"].as_u64().expect("a number"), of["shown"].as_u64().expect("a number"));
    page.give(PageAct::Why { about: "rush".to_owned() });
    page.wait_note("part 1");
    page.give(PageAct::Acknowledge { shown: id, note: "looking".to_owned() });
    page.wait("acknowledged", |page| {
        let of = alarm(page).map(|of| (&of["acknowledged"]["note"], &of["state"]));
        of.is_some_and(|(note, state)| note == "looking" && state == "active, acknowledged")
    });
    assert!(gripper("clear"), "the gripper works");
    page.give(PageAct::Answer { alarm: number, word: "somewhere".to_owned() });
    page.wait_note("\"somewhere\" is no answer to alarm 1; its answers: in-store");
    page.wait("acknowledged, refused, and still there", |page| alarm(page).is_some());
    page.give(PageAct::Answer { alarm: number, word: "in-store".to_owned() });
    page.wait_note("alarm 1 is answered: in-store");
    page.wait("the alarm is over", |page| alarm(page).is_none());
    page.give(PageAct::Answer { alarm: number, word: "in-store".to_owned() });
    page.wait_note("alarm 1 is over");
    page.wait("the order is finished", |page| {
        order(page, "rush")
            .is_some_and(|of| of["is_over"] == true && of["text"].as_str().is_some_and(|text| text.contains("1 of 1")))
    });

    let service = |to| PageAct::Resource { resource: "M3".to_owned(), to };
    let is_out = |page: &Value| page["cell"]["out_of_service"].as_array().is_some_and(|all| !all.is_empty());
    page.give(service(ResourceCommand::Down));
    page.wait_note("M3 is out of service");
    page.wait("it is out", is_out);
    page.give(service(ResourceCommand::Down));
    page.wait_note("already in that state");
    page.give(service(ResourceCommand::Up));
    page.wait_note("M3 is in service again");
    page.wait("it is back", |page| !is_out(page));

    send_signal("INT", process.id());
    assert!(process.wait().expect("a child").success());
    let log = std::fs::read_to_string(rig.state().join("console.log")).expect("it is there");
    for part in [
        "console: order `rush` of 1 A, due in 600 s by Ada (127.0.0.1:",
        "console: alarm `cell 1 ",
        "` acknowledged by Ada (127.0.0.1:",
        "console: answer \"in-store\" to alarm 1 by Ada (127.0.0.1:",
        "console: answer \"in-store\" to alarm 1: done: alarm 1 is answered: in-store",
        "console: resource M3 down by Ada",
    ] {
        assert!(log.contains(part), "{part}: {log}");
    }
    assert!(rig.log("coordinator").contains("request answer in-store by Ada"), "{}", rig.log("coordinator"));
    rig.signal("INT");
    rig.ended();
}
