//! The console: started before its line, it shows the line's modes as they change, that the line is gone, and the line again.
//!
//! ```text
//!   linewright run ──▶ nodes ── ROS topics ──▶ linewright console ── WebSocket ──▶ this test, as a page reads
//! ```

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use linewright_console_view::{PageAct, PageOperation, PageReader};
use linewright_msgs::StationState;
use serde_json::Value;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Message, WebSocket, client};

use crate::support::operator::Operator;
use crate::support::rig::{Rig, line, send_signal};
use crate::support::{PATIENCE, wait_for};

/// A page of the console.
pub struct PageOfConsole {
    socket: WebSocket<TcpStream>,
    reader: PageReader,
    connection: u64,
    address: String,
}

impl PageOfConsole {
    pub fn open(address: &str) -> Self {
        let stream = TcpStream::connect(address).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let mut request = format!("ws://{address}/feed").into_client_request().expect("a request");
        request.headers_mut().insert("origin", format!("http://{address}").parse().expect("a header"));
        let (mut socket, _) = client(request, stream).expect("it is served");
        let greeting = socket.read().expect("a greeting").into_text().expect("text");
        let greeting: Value = serde_json::from_str(&greeting).expect("JSON");
        let connection = greeting["connection"].as_u64().expect("its number");
        PageOfConsole { socket, reader: PageReader::default(), connection, address: address.to_owned() }
    }

    /// Does something, as of the frame that was read last.
    fn act(&mut self, act: PageAct) {
        let operation = PageOperation { seen_ms: self.reader.now_ms(), act, step: None };
        let text = serde_json::to_string(&operation).expect("JSON");
        self.socket.send(Message::text(text)).expect("sent");
    }

    /// Does something, as of a frame of now. The first one that is read may have waited since the last one was.
    pub fn give(&mut self, act: PageAct) {
        self.next().expect("a frame");
        self.next().expect("a frame");
        self.act(act);
    }

    /// Holds on to what is pressed.
    fn beat(&mut self, number: u64) {
        self.next().expect("a frame");
        self.act(PageAct::Beat { number });
    }

    pub fn take_control(&mut self) {
        self.next().expect("a frame");
        self.act(PageAct::Take { name: "Ada".to_owned() });
        let own = self.connection;
        self.wait("control", |page| page["control"]["holder"]["connection"] == own);
    }

    /// Waits until this stands at one of its buttons.
    pub fn wait_note(&mut self, text: &str) {
        let own = self.connection.to_string();
        self.wait(text, |page| page["control"]["notes"][&own]["text"].as_str().is_some_and(|of| of.contains(text)));
    }

    pub fn command(&mut self, word: &str, mode: &'static str) {
        self.give(PageAct::Command { word: word.to_owned(), station: None });
        self.wait(mode, is_mode(mode));
    }

    /// Takes the next frame; none when the console has ended.
    fn next(&mut self) -> Option<&Value> {
        let text = self.socket.read().ok()?.into_text().ok()?;
        let sequence = self.reader.take(&text).expect("a frame that fits");
        self.socket.send(Message::text(sequence.to_string())).ok()?;
        Some(self.reader.page())
    }

    /// Reads until the page is so.
    pub fn wait(&mut self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let is_there = wait_for(PATIENCE * 2, || {
            // One that was not read for a while, as on a busy machine, is dropped and connects again.
            if self.next().is_none() {
                *self = PageOfConsole::open(&self.address.clone());
            }
            holds(self.reader.page())
        });
        assert!(is_there, "{what}: {:#}", self.reader.page());
        self.reader.page().clone()
    }
}

/// A console that runs, with the address that it has printed.
pub fn console(rig: &Rig) -> (Child, String) {
    let mut command = rig.command(&["console"], &["--listen", "127.0.0.1:0"]);
    let log = File::create(rig.state().join("console.log")).expect("a file");
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(log).spawn().expect("the command starts");
    let mut printed = String::new();
    BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut printed).expect("a line");
    let address = printed.trim().strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
    (child, address.unwrap_or_else(|| panic!("no address: {printed}")).to_owned())
}

pub fn is_mode(word: &'static str) -> impl Fn(&Value) -> bool {
    move |page| page["mode"]["word"] == word && page["mode"]["is_known"] == true
}

fn all_stations(page: &Value, holds: impl Fn(&Value) -> bool) -> bool {
    page["stations"].as_array().is_some_and(|all| all.len() == 3 && all.iter().all(holds))
}

#[test]
fn a_page_shows_a_line_that_starts_changes_its_mode_ends_and_starts_again() {
    let mut rig = Rig::new(&line(0.3));
    let (mut console, address) = console(&rig);
    let mut page = PageOfConsole::open(&address);
    let before = page.wait("nothing is received", |page| page["mode"]["is_known"] == false);
    assert!(all_stations(&before, |station| station["health"] == "unknown"), "{before:#}");
    let operator = rig.in_stand_by();
    let ready =
        page.wait("stand-by", |page| is_mode("stand-by")(page) && all_stations(page, |of| of["health"] == "ok"));
    assert_eq!(ready["alarms"].as_array().map(Vec::len), Some(0), "{ready:#}");
    operator.order("auto", StationState::MODE_AUTO);
    page.wait("auto", is_mode("auto"));
    page.wait("a motion in its lane", |page| page["lanes"].to_string().contains(r#""kind":"moving""#));
    page.wait("a cycle time", |page| page["mode"]["cycle"]["duration_s"].as_f64().is_some_and(|took| took > 0.0));
    drop(operator);
    rig.ends_well(0);
    let gone = page.wait("the line is gone", |page| page["mode"]["is_known"] == false);
    assert!(
        gone["mode"]["text"].as_str().is_some_and(|text| text.contains("no state received from the coordinator for"))
    );
    page.wait("the stations are gone", |page| {
        all_stations(page, |of| of["operation"].is_null() && of["health"] == "unknown")
    });
    rig.start(&["--no-auto"]);
    let _operator = Operator::join(&rig);
    page.wait("the line again", |page| {
        page["mode"]["is_known"] == true && all_stations(page, |of| of["health"] != "unknown")
    });
    refused(&rig, &address);
    rig.signal("INT");
    rig.ended();
    send_signal("INT", console.id());
    assert!(wait_for(PATIENCE, || console.try_wait().expect("a child").is_some()), "Ctrl-C ends it");
    assert!(console.wait().expect("a child").success());
    assert!(wait_for(Duration::from_secs(5), || page.next().is_none()), "its pages are cut off");
}

/// Addresses that it does not listen on, each with the reason.
fn refused(rig: &Rig, in_use: &str) {
    let said = |address: &str| rig.said(&["console"], &["--listen", address]).expect_err("it is refused");
    for (address, reason) in [
        (in_use, "is in use by another program"),
        ("0.0.0.0:8080", "is not a loopback address"),
        ("8080", "expected an address with its port, e.g. 127.0.0.1:8080"),
    ] {
        let text = said(address).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(reason), "{address}: {text}");
    }
}

/// A page that holds *advance* of the bar, which moves.
fn holding(what: &str, address: &str, operator: &Operator) -> PageOfConsole {
    let mut page = PageOfConsole::open(address);
    page.take_control();
    page.give(PageAct::Press { number: 1, station: Some("transfer".to_owned()), button: "advance".to_owned() });
    let began = wait_for(PATIENCE, || {
        page.beat(1);
        !operator.heard().station("transfer").stopped
    });
    assert!(began, "{what}: it moves: {:#}", page.reader.page()["control"]);
    page
}

/// While a page holds *advance* another console holds it too: the bar stands, and stays.
fn stops_for_a_second_console(address: &str, operator: &Operator) {
    let mut page = holding("beside another console", address, operator);
    let finger = operator.hold("transfer", "advance");
    let has_stopped = wait_for(PATIENCE, || {
        page.beat(1);
        operator.heard().station("transfer").stopped
    });
    assert!(has_stopped, "it stands");
    let until = Instant::now() + Duration::from_secs(1);
    while Instant::now() < until {
        page.beat(1);
        assert!(operator.heard().station("transfer").stopped, "both hold on, and it stands");
    }
    page.wait("why it stands", |page| page["stations"].to_string().contains("two consoles send a button of it"));
    drop(finger);
}

/// Holds *advance* of the bar at a page until it moves, and loses the page; prints how long it moved on.
fn stops_without(what: &str, address: &str, operator: &Operator, lose: impl FnOnce(PageOfConsole)) {
    let page = holding(what, address, operator);
    let moves = || !operator.heard().station("transfer").stopped;
    let lost = Instant::now();
    lose(page);
    assert!(wait_for(PATIENCE, || !moves()), "{what}: it stops");
    let within = lost.elapsed();
    println!("{what}: the bar stood {within:?} later");
    // The age from which controllers ignore a button, that of a beat, and time for this machine.
    assert!(within < Duration::from_millis(1000 + 250 + 500), "{what}: {within:?}");
    assert!(!operator.heard().station("transfer").incomplete.is_empty(), "{what}: it stands before its end");
}

/// ```text
///  page 1 ─┐ WebSocket            ROS 2
///  page 2 ─┴──────────▶ console ────────▶ the shipped line, simulated
/// ```
#[test]
fn one_page_commands_a_line_and_what_it_holds_ends_with_it() {
    // One lift takes longer than all that is held here.
    let mut rig = Rig::new(&line(30.0));
    rig.start(&["--no-auto"]);
    let operator = Operator::join(&rig);
    let (mut process, address) = console(&rig);
    let mut page = PageOfConsole::open(&address);
    page.wait("home", is_mode("home"));
    page.act(PageAct::Command { word: "start".to_owned(), station: None });
    page.wait_note("this page has no control");
    page.take_control();
    page.command("start", "stand-by");
    page.command("auto", "auto");
    page.next().expect("a frame");
    page.act(PageAct::Command { word: "hand".to_owned(), station: None });
    page.wait_note("not possible in auto; possible: stop");
    let mut other = PageOfConsole::open(&address);
    other.take_control();
    let own = other.connection;
    page.wait("it has lost control", |page| page["control"]["holder"]["connection"] == own);
    other.command("estop", "e-stop");
    other.next().expect("a frame");
    other.act(PageAct::Command { word: "reset".to_owned(), station: None });
    other.wait("reset", |page| page["mode"]["text"].as_str().is_some_and(|of| of.contains("select manual")));
    other.command("manual", "manual");
    drop((page, other));
    stops_for_a_second_console(&address, &operator);
    stops_without("a page that is cut off", &address, &operator, drop);
    stops_without("a page that is silent", &address, &operator, std::mem::forget);
    stops_without("a console that is killed", &address, &operator, |_page| {
        process.kill().expect("it runs");
    });
    process.wait().expect("a child");
    let log = std::fs::read_to_string(rig.state().join("console.log")).expect("it is there");
    assert!(log.contains("console: start commanded by Ada (127.0.0.1:"), "{log}");
    rig.signal("INT");
    rig.ended();
}
