//! The page in a real browser: what it shows, that it is grey when its server is gone, and that it comes back.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use linewright_console_server::PageServer;
use linewright_console_view::{Aged, ConsoleInputs, ConsoleView, PageFeed};
use linewright_line::Line;
use linewright_msgs::{LineState, StationState};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep};

use crate::driver::{Browser, IS_LIVE, IS_LOST, PATIENCE};

/// Longest time from the last frame to a grey page, in ms, as documented, with the time that the driver takes for the request that
/// notes the begin before the server is ended.
const GREY_WITHIN_MS: f64 = 650.0;

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
        let mut view = ConsoleView::new(&line, None, |_| "auto");
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
