//! The page in a real browser: what it shows, that it is grey when its server is gone, and that it comes back.
//!
//! Chromium is driven by its own driver, whose protocol (W3C WebDriver) is JSON over HTTP; of it only what is needed here. Without them
//! (Debian: `chromium`, `chromium-driver`) the test prints SKIPPED.

use std::io::Write;
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use linewright_console_server::{PageEvent, PageEventKind, PageServer};
use linewright_console_view::{Aged, ConsoleInputs, ConsoleView, ControlDesk, PageFeed};
use linewright_line::Line;
use linewright_msgs::{LineState, StationState};
use serde_json::{Value, json};
use tokio::io::{AsyncBufReadExt, AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, BufReader};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, timeout};

/// For a machine that is busy with other things.
const PATIENCE: Duration = Duration::from_secs(40);

/// Longest time from the last frame to a grey page, in ms, as documented, with the time that the driver takes for the request that
/// notes the begin before the server is ended.
const GREY_WITHIN_MS: f64 = 650.0;

/// A browser with its driver; both end with it.
struct Browser {
    driver: Child,
    port: u16,
    session: String,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It ends its browsers before itself; killed, it would leave them.
        if let Ok(mut stream) = std::net::TcpStream::connect(("127.0.0.1", self.port)) {
            let _ = stream.write_all(b"GET /shutdown HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
            let end = std::time::Instant::now() + Duration::from_secs(10);
            while matches!(self.driver.try_wait(), Ok(None)) && std::time::Instant::now() < end {
                std::thread::sleep(Duration::from_millis(20));
            }
        }
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

impl Browser {
    /// Starts them; the reason where they are not installed.
    async fn open() -> Result<Self, String> {
        let port =
            std::net::TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port").port();
        let mut command = Command::new("chromedriver");
        command.arg(format!("--port={port}")).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let driver = command.spawn().map_err(|error| format!("chromedriver: {error}"))?;
        let mut browser = Browser { driver, port, session: String::new() };
        let listens = async {
            while TcpStream::connect(("127.0.0.1", port)).await.is_err() {
                sleep(Duration::from_millis(50)).await;
            }
        };
        timeout(PATIENCE, listens).await.expect("chromedriver listens");
        let options =
            ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--window-size=800,480"];
        let asked = json!({ "capabilities": { "alwaysMatch": { "goog:chromeOptions": { "args": options } } } });
        match browser.ask("POST", "/session", &asked).await {
            Ok(opened) => browser.session = opened["sessionId"].as_str().expect("a session").to_owned(),
            Err(why) if why.contains("cannot find Chrome") => return Err(why),
            Err(why) => panic!("{why}"),
        }
        Ok(browser)
    }

    /// Starts them, or prints that the test is skipped, and why.
    async fn open_or_skip() -> Option<Self> {
        let opened = Browser::open().await;
        opened.map_err(|why| println!("SKIPPED: no Chromium with its driver here ({why})")).ok()
    }

    /// A request of the protocol; gives its value.
    async fn ask(&self, method: &str, path: &str, asked: &Value) -> Result<Value, String> {
        let body = asked.to_string();
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            self.port,
            body.len()
        );
        let exchange = async {
            let mut stream = BufReader::new(TcpStream::connect(("127.0.0.1", self.port)).await?);
            stream.write_all(request.as_bytes()).await?;
            // The connection stays open: the length of the body is in the head.
            let (mut length, mut head) = (0, String::new());
            while stream.read_line(&mut head).await? > 2 {
                let name = head.to_ascii_lowercase();
                length = name.strip_prefix("content-length:").and_then(|of| of.trim().parse().ok()).unwrap_or(length);
                head.clear();
            }
            let mut body = vec![0; length];
            stream.read_exact(&mut body).await?;
            std::io::Result::Ok(body)
        };
        let body = timeout(PATIENCE, exchange).await.map_err(|_| format!("{path}: no answer"))?;
        let body = body.map_err(|error| format!("{path}: {error}"))?;
        let mut json: Value = serde_json::from_slice(&body).map_err(|error| format!("{path}: {error}"))?;
        let value = json["value"].take();
        if value.get("error").is_some() { Err(value["message"].to_string()) } else { Ok(value) }
    }

    async fn script(&self, script: &str) -> Value {
        let path = format!("/session/{}/execute/sync", self.session);
        self.ask("POST", &path, &json!({ "script": script, "args": [] })).await.expect("it runs")
    }

    async fn visit(&self, url: &str) {
        let path = format!("/session/{}/url", self.session);
        self.ask("POST", &path, &json!({ "url": url })).await.expect("it is loaded");
    }

    /// Waits until a condition of the page holds.
    async fn wait(&self, condition: &str) {
        let end = Instant::now() + PATIENCE;
        while self.script(&format!("return Boolean({condition})")).await != true {
            assert!(Instant::now() < end, "{condition}: {}", self.script("return document.body.innerText").await);
            sleep(Duration::from_millis(30)).await;
        }
    }
}

/// A server whose line is in this mode, ten times a second.
async fn serve(address: SocketAddr, mode: &'static str) -> (JoinHandle<()>, SocketAddr) {
    let end = Instant::now() + PATIENCE;
    let server = loop {
        match PageServer::bind(address).await {
            Ok(server) => break server,
            Err(error) => assert!(Instant::now() < end, "{error}"),
        }
        sleep(Duration::from_millis(20)).await;
    };
    let address = server.address();
    let served = tokio::spawn(async move {
        let text = linewright_line::TransferLine::default().text();
        let line: Line = linewright_line::parse("line.toml", &text).expect("parses").line;
        let (frames, newest) = watch::channel(None);
        let (to, _events) = mpsc::channel(100);
        let state = LineState { mode: StationState::MODE_AUTO, text: mode.to_owned(), ..LineState::default() };
        let mut view = ConsoleView::new(&line, false, |_| "auto");
        let (mut feed, begin) = (PageFeed::default(), Instant::now());
        let mut ticks = tokio::time::interval(Duration::from_millis(100));
        let publish = async {
            loop {
                ticks.tick().await;
                let nothing = ConsoleInputs::nothing(begin.elapsed(), &line);
                let page =
                    view.page(&ConsoleInputs { line: Some(Aged { state: &state, age: Duration::ZERO }), ..nothing });
                frames.send_replace(Some(Arc::new(feed.frame(begin.elapsed(), &page))));
            }
        };
        // Ends both, and with the sender every connection.
        tokio::select! {
            () = server.run(newest, to) => {}
            () = publish => {}
        }
    });
    (served, address)
}

/// The tests of a page by its style: it is grey, its mode is struck through, and the time of the loss is shown.
const IS_LOST: &str = "document.documentElement.classList.contains('lost') && document.getElementById('lost') \
                       && getComputedStyle(document.getElementById('mode')).textDecorationLine === 'line-through' \
                       && getComputedStyle(document.body).filter === 'grayscale(1)'";
const IS_LIVE: &str = "!document.documentElement.classList.contains('lost') && !document.getElementById('lost') \
                       && getComputedStyle(document.getElementById('mode')).textDecorationLine === 'none'";

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_page_without_its_server_is_grey_at_once_and_comes_back() {
    let Some(browser) = Browser::open_or_skip().await else { return };
    let (mut served, address) = serve("127.0.0.1:0".parse().expect("an address"), "auto, first").await;
    browser.visit(&format!("http://{address}/")).await;
    browser.wait(IS_LIVE).await;
    browser.wait("document.getElementById('mode').innerText === 'auto'").await;
    browser.wait("document.body.innerText.includes('auto, first')").await;
    for (page, shows) in [
        ("chart", "document.querySelectorAll('.bar.unknown').length > 5"),
        ("alarms", "document.querySelectorAll('tbody tr').length === 3"),
        ("waiting", "document.querySelectorAll('main .is-unknown').length === 3"),
        ("cell", "document.querySelectorAll('.card.unknown').length === 3"),
        ("overview", "document.querySelectorAll('.card.unknown').length === 3"),
    ] {
        browser.script(&format!("location.hash = '#{page}'")).await;
        browser.wait(shows).await;
    }
    let note = "window.grey = null; const of = document.documentElement; window.seen?.disconnect(); \
                window.seen = new MutationObserver(() => { if (of.classList.contains('lost')) window.grey ??= performance.now(); }); \
                window.seen.observe(of, { attributes: true }); return performance.now()";
    let mut within = Vec::new();
    for again in ["auto, second", "auto, third", "auto, fourth"] {
        let ended = browser.script(note).await.as_f64().expect("a time");
        served.abort();
        browser.wait(IS_LOST).await;
        within.push(browser.script("return window.grey").await.as_f64().expect("a time") - ended);
        served = serve(address, again).await.0;
        browser.wait(IS_LIVE).await;
        browser.wait(&format!("document.body.innerText.includes('{again}')")).await;
    }
    // One that takes longer may be this machine's.
    println!("grey within {within:.0?} ms");
    assert!(within.iter().any(|of| *of < GREY_WITHIN_MS), "{within:?}");
}

/// Passes a connection on, each piece of it later by `delay` (ms) as that is when it comes.
async fn pass_on(mut from: impl AsyncRead + Unpin, mut to: impl AsyncWrite + Unpin, delay: Arc<AtomicU64>) {
    let mut piece = vec![0; 1 << 16];
    while let Ok(length) = from.read(&mut piece).await {
        sleep(Duration::from_millis(delay.load(Ordering::Relaxed))).await;
        if length == 0 || to.write_all(&piece[..length]).await.is_err() {
            return;
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn frames_that_were_seconds_under_way_never_look_as_if_they_were_of_now() {
    let Some(browser) = Browser::open_or_skip().await else { return };
    // Each server answers to 127.0.0.1 with its own port: what is between has that name.
    let (_served, address) = serve("127.0.0.2:0".parse().expect("an address"), "auto, late").await;
    let between = SocketAddr::from(([127, 0, 0, 1], address.port()));
    let listener = TcpListener::bind(between).await.expect("a free port");
    let delay = Arc::new(AtomicU64::new(0));
    let of = delay.clone();
    let _between = tokio::spawn(async move {
        while let Ok((page, _)) = listener.accept().await {
            let server = TcpStream::connect(address).await.expect("it listens");
            let ((from_page, to_page), (from_server, to_server)) = (page.into_split(), server.into_split());
            tokio::spawn(pass_on(from_page, to_server, Arc::default()));
            tokio::spawn(pass_on(from_server, to_page, of.clone()));
        }
    });
    browser.visit(&format!("http://{between}/")).await;
    browser.wait(IS_LIVE).await;
    delay.store(1200, Ordering::Relaxed);
    browser.wait(IS_LOST).await;
    let count = "window.live = 0; const of = document.documentElement; \
                 new MutationObserver(() => { if (!of.classList.contains('lost')) window.live += 1; }) \
                 .observe(of, { attributes: true }); return 0";
    browser.script(count).await;
    sleep(Duration::from_millis(2600)).await;
    assert_eq!(browser.script("return window.live").await, 0, "late frames were shown as those of now");
    delay.store(0, Ordering::Relaxed);
    browser.wait(IS_LIVE).await;
}

/// What a desk has published, with the times.
type Published = Arc<Mutex<Vec<(Instant, bool)>>>;

/// A server with a desk, whose line is in manual.
async fn serve_desk() -> (JoinHandle<()>, SocketAddr, Published) {
    let server = PageServer::bind("127.0.0.1:0".parse().expect("an address")).await.expect("a free port");
    let address = server.address();
    let published = Published::default();
    let notes = published.clone();
    let served = tokio::spawn(async move {
        let text = linewright_line::TransferLine::default().text();
        let line: Line = linewright_line::parse("line.toml", &text).expect("parses").line;
        let ((frames, newest), (to, mut events)) = (watch::channel(None), mpsc::channel(100));
        let mode = StationState::MODE_MANUAL;
        let state = LineState { mode, text: "manual".to_owned(), ..LineState::default() };
        let station = StationState { mode, devices_valid: true, stopped: true, ..StationState::default() };
        let mut view = ConsoleView::new(&line, false, |_| "manual");
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
                            PageEventKind::Operated(of) => drop(desk.take(begin.elapsed(), connection, &of, |_| None)),
                        }
                    }
                    _ = looks.tick() => {}
                    _ = ticks.tick() => {
                        let nothing = ConsoleInputs::nothing(begin.elapsed(), &line);
                        let stations = vec![Some(Aged { state: &station, age: Duration::ZERO }); line.stations.len()];
                        let line = Some(Aged { state: &state, age: Duration::ZERO });
                        let control = desk.part(begin.elapsed());
                        let page = view.page(&ConsoleInputs { line, stations, control, ..nothing });
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
    (served, address, published)
}

/// Acts of a pointer or the keyboard, as WebDriver takes them.
impl Browser {
    async fn act(&self, of: &Value) {
        let path = format!("/session/{}/actions", self.session);
        self.ask("POST", &path, &json!({ "actions": [of] })).await.expect("it is done");
    }

    async fn pointer(&self, acts: Value) {
        self.act(
            &json!({ "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": acts }),
        )
        .await;
    }

    /// The middle of a button.
    async fn middle(&self, key: &str) -> (i64, i64) {
        let script = format!(
            "const of = document.querySelector('[data-key=\"{key}\"]'); of.scrollIntoView({{ block: 'center' }}); \
             const box = of.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]"
        );
        let at = self.script(&script).await;
        (at[0].as_f64().expect("a number") as i64, at[1].as_f64().expect("a number") as i64)
    }

    async fn press(&self, (x, y): (i64, i64)) {
        self.pointer(json!([{ "type": "pointerMove", "x": x, "y": y }, { "type": "pointerDown", "button": 0 }])).await;
    }

    async fn let_go(&self) {
        self.pointer(json!([{ "type": "pointerUp", "button": 0 }])).await;
    }
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
    let (served, address, published) = serve_desk().await;
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
    let ends: [(&str, &str); 6] = [
        ("let go", ""),
        ("slid off", "pointer has left the button"),
        ("blur", "the page was left"),
        ("a key", "something else was touched"),
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
        browser.let_go().await;
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
