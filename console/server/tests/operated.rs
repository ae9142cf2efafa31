//! Buttons in a real browser: for how long one is held, what a page without control gives, and the button of the next step.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use linewright_console_server::{PageEvent, PageEventKind, PageServer};
use linewright_console_view::{
    Aged, ConsoleInputs, ConsoleView, ControlDesk, DeskEffect, OperateButton, PageAct, PageFeed, PlanPart, PlanStepPart,
};
use linewright_line::Line;
use linewright_msgs::{LineState, StationState};
use serde_json::json;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep};

use crate::driver::{Browser, IS_LIVE, PATIENCE};

/// What a desk has published, with the times.
type Published = Arc<Mutex<Vec<(Instant, bool)>>>;

/// The station whose *advance* comes next.
type NextStation = Arc<Mutex<&'static str>>;

/// A way back whose next step is *advance* of this station.
fn plan(station: &str) -> PlanPart {
    let act = PageAct::Press { number: 0, station: Some(station.to_owned()), button: "advance".to_owned() };
    let (key, label) = (act.key().expect("a button"), format!("advance of {station}"));
    let step = PlanStepPart { text: format!("hold {label}"), since: None, stands: Vec::new() };
    let button = Some(OperateButton { key, label, act, why_not: None });
    PlanPart { begin: Vec::new(), steps: vec![step], end: Vec::new(), next: Some(0), button, step: 0 }
}

/// What the desk of a test has published and has to do, and what its page shows.
#[derive(Clone, Default)]
struct DeskBench {
    published: Published,
    effects: Arc<Mutex<Vec<DeskEffect>>>,
    next: NextStation,
}

/// A server with a desk, whose line is in manual.
async fn serve_desk() -> (JoinHandle<()>, SocketAddr, DeskBench) {
    let server = PageServer::bind("127.0.0.1:0".parse().expect("an address")).await.expect("a free port");
    let address = server.address();
    let bench = DeskBench { next: Arc::new(Mutex::new("transfer")), ..DeskBench::default() };
    let DeskBench { published: notes, effects: done, next } = bench.clone();
    let served = tokio::spawn(async move {
        let text = linewright_line::TransferLine::default().text();
        let line: Line = linewright_line::parse("line.toml", &text).expect("parses").line;
        let ((frames, newest), (to, mut events)) = (watch::channel(None), mpsc::channel(100));
        let mode = StationState::MODE_MANUAL;
        let state = LineState { mode, text: "manual".to_owned(), console_lost: true, ..LineState::default() };
        let station = StationState { mode, devices_valid: true, stopped: true, ..StationState::default() };
        let mut view = ConsoleView::new(&line, None, |_| "manual");
        let (mut feed, mut desk, begin) = (PageFeed::default(), ControlDesk::new(&line), Instant::now());
        let (mut ticks, mut looks) =
            (tokio::time::interval(Duration::from_millis(100)), tokio::time::interval(Duration::from_millis(25)));
        let work = async {
            loop {
                tokio::select! {
                    biased;
                    event = events.recv() => {
                        let PageEvent { connection, what } = event.expect("it serves");
                        match what {
                            PageEventKind::Opened(from) => desk.opened(connection, &from),
                            PageEventKind::Closed => drop(desk.closed(begin.elapsed(), connection)),
                            PageEventKind::Operated(of) => {
                                let effects = desk.take(begin.elapsed(), connection, &of, |_| None);
                                done.lock().expect("whole").extend(effects);
                            }
                        }
                    }
                    _ = looks.tick() => {}
                    _ = ticks.tick() => {
                        let nothing = ConsoleInputs::nothing(begin.elapsed(), &line);
                        let stations = vec![Some(Aged { state: &station, age: Duration::ZERO }); line.stations.len()];
                        let line = Some(Aged { state: &state, age: Duration::ZERO });
                        let control = desk.part(begin.elapsed());
                        let plan = desk.plan(begin.elapsed(), Some(plan(&next.lock().expect("whole"))), true);
                        let page = view.page(&ConsoleInputs { line, stations, control, plan, ..nothing });
                        frames.send_replace(Some(Arc::new(feed.frame(begin.elapsed(), &page))));
                    }
                }
                let (messages, _) = desk.due(begin.elapsed(), |_| None);
                notes.lock().expect("whole").extend(messages.iter().map(|of| (Instant::now(), of.is_held)));
            }
        };
        tokio::select! {
            () = server.run(newest, to) => {}
            () = work => {}
        }
    });
    (served, address, bench)
}

impl Browser {
    /// Presses a button, and whether it stays held. On a machine that is busy with other things a page may be stalled for long enough to
    /// release it: then it is pressed anew.
    async fn holds(&self, key: &str, published: &Published) -> bool {
        for _ in 0..10 {
            self.press(self.middle(key).await).await;
            let end = Instant::now() + Duration::from_secs(2);
            while !is_held(published) && Instant::now() < end {
                sleep(Duration::from_millis(5)).await;
            }
            sleep(Duration::from_millis(700)).await;
            if is_held(published) {
                return true;
            }
            println!("released: {}", self.script("return document.querySelector('main .remark')?.innerText").await);
            self.let_go().await;
        }
        false
    }
}

fn is_held(published: &Published) -> bool {
    let all = published.lock().expect("whole");
    all.last().is_some_and(|(at, held)| *held && at.elapsed() < Duration::from_millis(200))
}

async fn becomes(what: &str, holds: impl Fn() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < end, "{what}");
        sleep(Duration::from_millis(5)).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_button_is_held_while_the_pointer_or_the_space_bar_is_down_on_it_and_never_longer() {
    let Some(browser) = Browser::open_or_skip().await else { return };
    let (served, address, bench) = serve_desk().await;
    let published = bench.published;
    browser.visit(&format!("http://{address}/#operate")).await;
    browser.wait(IS_LIVE).await;
    let key = "hold advance mill_1";
    let at = browser.middle(key).await;
    // Without control it says so, and nothing is published.
    browser.press(at).await;
    browser.let_go().await;
    browser.wait("document.body.innerText.includes('this page has no control; take it first')").await;
    assert!(published.lock().expect("whole").is_empty());
    browser.script("document.querySelector('#control button').click()").await;
    browser.wait("document.querySelector('#control.own')").await;
    let ends: [(&str, &str); 8] = [
        ("let go", ""),
        ("slid off", "pointer has left the button"),
        ("blur", "the page was left"),
        ("a key", "something else was touched"),
        ("a second button of the mouse", "something else was touched"),
        ("the space bar meanwhile", "something else was touched"),
        ("the button goes away", "has left the button"),
        ("a page that does nothing", "released: "),
    ];
    for (end, why) in ends {
        assert!(browser.holds(key, &published).await, "{end}: it is held as long as it is pressed");
        let begin = Instant::now();
        match end {
            "let go" => browser.let_go().await,
            "slid off" => browser.pointer(json!([{ "type": "pointerMove", "x": 5, "y": 5 }])).await,
            "blur" => drop(browser.script("window.dispatchEvent(new Event('blur'))").await),
            "a key" => {
                let keys = json!([{ "type": "keyDown", "value": "a" }, { "type": "keyUp", "value": "a" }]);
                browser.act(&json!({ "type": "key", "id": "keyboard", "actions": keys })).await;
            }
            // The browser has no event of its own for it: the next move tells.
            "a second button of the mouse" => {
                let (x, y) = browser.middle(key).await;
                browser
                    .pointer(
                        json!([{ "type": "pointerDown", "button": 2 }, { "type": "pointerMove", "x": x + 1, "y": y }]),
                    )
                    .await;
            }
            "the space bar meanwhile" => {
                browser
                    .act(&json!({ "type": "key", "id": "keyboard", "actions": [{ "type": "keyDown", "value": " " }] }))
                    .await;
            }
            "the button goes away" => {
                drop(browser.script("document.querySelector('main').style.paddingTop = '2000px'").await)
            }
            _ => {
                let busy = "const end = performance.now() + 1500; while (performance.now() < end); return 0";
                browser.script(busy).await;
            }
        }
        becomes(end, || !is_held(&published)).await;
        let last = published.lock().expect("whole").iter().rev().find(|(_, held)| *held).expect("it was held").0;
        println!("{end}: last held {:?} after it", last.saturating_duration_since(begin));
        assert!(last.saturating_duration_since(begin) < Duration::from_millis(600), "{end}");
        // The pointer is still down: back inside, it begins nothing.
        browser.script("document.querySelector('main').style.paddingTop = ''").await;
        let (x, y) = browser.middle(key).await;
        browser.pointer(json!([{ "type": "pointerMove", "x": x, "y": y }])).await;
        sleep(Duration::from_millis(500)).await;
        assert!(!is_held(&published), "{end}: it has begun again by itself");
        browser.wait(&format!("document.body.innerText.includes('{why}')")).await;
        match end {
            // It is down on the button that has the focus: it is no press of its own, and none follows when the pointer is let go.
            "the space bar meanwhile" => {
                browser.let_go().await;
                sleep(Duration::from_millis(500)).await;
                assert!(!is_held(&published), "{end}: it has begun another hold");
                browser
                    .act(&json!({ "type": "key", "id": "keyboard", "actions": [{ "type": "keyUp", "value": " " }] }))
                    .await;
            }
            "a second button of the mouse" => {
                browser
                    .pointer(json!([{ "type": "pointerUp", "button": 2 }, { "type": "pointerUp", "button": 0 }]))
                    .await;
            }
            _ => browser.let_go().await,
        }
    }
    // The space bar, on the button that has the focus.
    browser.script(&format!("document.querySelector('[data-key=\"{key}\"]').focus()")).await;
    browser.act(&json!({ "type": "key", "id": "keyboard", "actions": [{ "type": "keyDown", "value": " " }] })).await;
    becomes("space", || is_held(&published)).await;
    browser.act(&json!({ "type": "key", "id": "keyboard", "actions": [{ "type": "keyUp", "value": " " }] })).await;
    becomes("space let go", || !is_held(&published)).await;
    // A browser that is gone.
    assert!(browser.holds(key, &published).await, "pressed");
    let begin = Instant::now();
    drop(browser);
    becomes("the browser is gone", || !is_held(&published)).await;
    let last = published.lock().expect("whole").iter().rev().find(|(_, held)| *held).expect("it was held").0;
    println!(
        "a browser that is ended: last held {:?} after the order to end it",
        last.saturating_duration_since(begin)
    );
    served.abort();
}

/// Whether this was commanded.
fn is_commanded(bench: &DeskBench, word: &str) -> bool {
    bench.effects.lock().expect("whole").contains(&DeskEffect::Command(word.to_owned()))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_page_without_control_gives_the_stop_and_nothing_else() {
    let Some(browser) = Browser::open_or_skip().await else { return };
    let (served, address, bench) = serve_desk().await;
    browser.visit(&format!("http://{address}/#operate")).await;
    browser.wait(IS_LIVE).await;
    assert!(browser.script("return document.querySelector('#control.own')").await.is_null());
    for key in ["command start", "command stop"] {
        browser.script(&format!("document.querySelector('[data-key=\"{key}\"]').click()")).await;
        browser.wait("document.body.innerText.includes('this page has no control; take it first')").await;
    }
    browser.script("document.querySelector('[data-key=\"command estop\"]').click()").await;
    becomes("the stop is given", || is_commanded(&bench, "estop")).await;
    assert!(!is_commanded(&bench, "start") && !is_commanded(&bench, "stop"));
    served.abort();
}

/// *Acknowledge* without a chosen alarm shows what is missing; with one it gives the alarm and the note.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_alarm_is_chosen_and_acknowledged_with_a_note() {
    let Some(browser) = Browser::open_or_skip().await else { return };
    let (served, address, bench) = serve_desk().await;
    browser.visit(&format!("http://{address}/#alarms")).await;
    browser.wait(IS_LIVE).await;
    browser.script("document.querySelector('#control button').click()").await;
    browser.wait("document.querySelector('#control.own')").await;
    let click = "document.querySelector('[data-key=\"acknowledge\"]').click()";
    browser.script(click).await;
    browser.wait("document.body.innerText.includes('choose the alarm first')").await;
    let enter = "const set = (of, value, name) => { const at = document.querySelector(`[data-choice=\"${of}\"]`); at.value = value; \
                 at.dispatchEvent(new Event(name, { bubbles: true })) }; \
                 set('alarm', document.querySelector('[data-choice=\"alarm\"]').options[1].value, 'change'); \
                 set('note', 'supply is off', 'input'); return 0";
    browser.script(enter).await;
    browser
        .wait("document.querySelector('[data-key=\"acknowledge\"]').getAttribute('aria-disabled') === 'false'")
        .await;
    browser.script(click).await;
    let is_acknowledged = || {
        let effects = bench.effects.lock().expect("whole");
        effects.iter().any(|of| matches!(of, DeskEffect::Acknowledge { note, .. } if note == "supply is off"))
    };
    becomes("it is acknowledged", is_acknowledged).await;
    served.abort();
}

/// The button of the next step stands at one place, and does another thing after each step.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_button_of_the_next_step_keeps_its_place_and_does_nothing_just_after_its_step_has_changed() {
    let Some(browser) = Browser::open_or_skip().await else { return };
    let (served, address, bench) = serve_desk().await;
    browser.visit(&format!("http://{address}/#operate")).await;
    browser.wait(IS_LIVE).await;
    browser.script("document.querySelector('#control button').click()").await;
    browser.wait("document.querySelector('#control.own')").await;
    let place = "const at = (of) => { const box = document.querySelector(of).getBoundingClientRect(); \
                 return [box.x, box.y + scrollY, box.width, box.height] }; \
                 return [at('.next-step button'), at('[data-key=\"hold return mill_1\"]')]";
    let is_ready = "document.querySelector('.next-step button').getAttribute('aria-disabled') === 'false'";
    let is_of = |station: &str| format!("document.querySelector('.next-step button').innerText.includes('{station}')");
    browser.wait(&format!("{} && {is_ready}", is_of("transfer"))).await;
    let before = browser.script(place).await;
    *bench.next.lock().expect("whole") = "mill_1";
    browser.wait(&is_of("mill_1")).await;
    let at = browser.script(
        "const of = document.querySelector('.next-step button'); of.scrollIntoView({ block: 'center' }); \
         const box = of.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]",
    );
    let at = at.await;
    let at = (at[0].as_f64().expect("a number") as i64, at[1].as_f64().expect("a number") as i64);
    // On a busy machine the time of rest may be over by now: the step changes until a press meets it.
    let mut has_met = false;
    for station in ["clamp_1", "mill_1", "transfer", "clamp_1", "mill_1", "transfer"] {
        *bench.next.lock().expect("whole") = station;
        browser.wait(&is_of(station)).await;
        let is_inert = browser.script(&format!("return !({is_ready})")).await == true;
        browser.press(at).await;
        let remark = browser.script("return document.querySelector('.next-step .remark').innerText").await;
        sleep(Duration::from_millis(300)).await;
        let was_held = is_held(&bench.published);
        browser.let_go().await;
        if is_inert && !was_held && remark.as_str().is_some_and(|of| of.contains("just changed")) {
            has_met = true;
            break;
        }
        becomes("let go", || !is_held(&bench.published)).await;
    }
    assert!(has_met, "a press just after a change does nothing");
    browser.wait(is_ready).await;
    assert_eq!(browser.script(place).await, before, "its place, and that of what stands below");
    browser.press(at).await;
    becomes("read, and then pressed", || is_held(&bench.published)).await;
    browser.let_go().await;
    becomes("let go", || !is_held(&bench.published)).await;
    served.abort();
}
