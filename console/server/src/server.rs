//! The socket, its connections and what each request is answered.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use linewright_console_view::{PAGE_MESSAGE_MAX, PageFrame};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, mpsc, watch};
use tokio::time::timeout;

use crate::origin::OwnNames;
use crate::page::ASSETS;
use crate::reader::{self, PageEvent};

/// The newest frame; none before the first.
pub type NewestFrame = watch::Receiver<Option<Arc<PageFrame>>>;

/// Most readers of frames at one time. One more is refused.
pub const READERS_MAX: usize = 100;

/// Most connections at one time that have not become a reader's. One more waits.
pub const CONNECTIONS_MAX: usize = 64;

/// Time in which a request is there with all its headers; afterwards the connection ends.
const REQUEST_WITHIN: Duration = Duration::from_secs(5);

/// Time after which a connection that has not become a reader's ends, also one that does not read its answers.
const CONNECTION_WITHIN: Duration = Duration::from_secs(30);

/// Most bytes of a request with its headers.
const REQUEST_MAX: usize = 16 * 1024;

/// Pause after a connection could not be accepted, as without free file descriptors.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// The address of the feed.
const FEED: &str = "/feed";

/// HTTP headers of every response: a page loads and runs scripts and styles of this server alone, nothing is kept in a cache, and no other
/// page may embed it in a frame.
const HEADERS: [(header::HeaderName, &str); 7] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self'; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::CACHE_CONTROL, "no-store"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (header::HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

/// Why a server does not listen.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// Not of this machine alone.
    #[error(
        "{0} is not a loopback address: a console for other hosts needs TLS and log-in, which are not built yet; use 127.0.0.1:{port}, \
         from another host through an SSH tunnel",
        port = .0.port()
    )]
    NotLoopback(SocketAddr),
    /// Another program listens there.
    #[error("{0} is in use by another program; end that one, or choose another port with `--listen`")]
    InUse(SocketAddr),
    #[error("cannot listen on {address}: {error}")]
    Failed { address: SocketAddr, error: io::Error },
}

/// A server that listens.
#[derive(Debug)]
pub struct PageServer {
    listener: TcpListener,
    address: SocketAddr,
}

impl PageServer {
    /// Listens on a loopback address; port 0 chooses a free one.
    ///
    /// # Errors
    /// When the address is another one, or cannot be listened on.
    pub async fn bind(address: SocketAddr) -> Result<Self, ListenError> {
        if !address.ip().is_loopback() {
            return Err(ListenError::NotLoopback(address));
        }
        let failed = |error: io::Error| match error.kind() {
            io::ErrorKind::AddrInUse => ListenError::InUse(address),
            _ => ListenError::Failed { address, error },
        };
        let listener = TcpListener::bind(address).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        Ok(PageServer { listener, address })
    }

    /// What is opened in a browser.
    pub fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// The address with its port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Serves until it is dropped; its connections end when `frames` has no sender any more, or `events` no receiver. What comes while
    /// `events` is full ends its connection.
    pub async fn run(self, frames: NewestFrame, events: mpsc::Sender<PageEvent>) {
        let router = router(OwnNames::of(self.address), frames, events);
        let connections = Arc::new(Semaphore::new(CONNECTIONS_MAX));
        loop {
            let Ok(permit) = connections.clone().acquire_owned().await else { return };
            let Ok((stream, from)) = self.listener.accept().await else {
                tokio::time::sleep(ACCEPT_PAUSE).await;
                continue;
            };
            let router = router.clone().layer(Extension(from));
            tokio::spawn(async move {
                connection(stream, router).await;
                drop(permit);
            });
        }
    }
}

/// Answers the requests of a connection. An error of one connection is the end of that one alone.
async fn connection(stream: TcpStream, router: Router) {
    // A frame is not kept back for the next one.
    let _ = stream.set_nodelay(true);
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(REQUEST_WITHIN).max_buf_size(REQUEST_MAX);
    let served = http.serve_connection(TokioIo::new(stream), TowerToHyperService::new(router)).with_upgrades();
    let _ = timeout(CONNECTION_WITHIN, served).await;
}

#[derive(Clone)]
struct Feed {
    frames: NewestFrame,
    readers: Arc<Semaphore>,
    /// Of the connection opened last.
    number: Arc<AtomicU64>,
    events: mpsc::Sender<PageEvent>,
}

fn router(own: OwnNames, frames: NewestFrame, events: mpsc::Sender<PageEvent>) -> Router {
    let feed = Feed { frames, readers: Arc::new(Semaphore::new(READERS_MAX)), number: Arc::default(), events };
    let mut router = Router::new().route(FEED, get(open_feed)).with_state(feed);
    for asset in &ASSETS {
        let answer = ([(header::CONTENT_TYPE, asset.content_type)], asset.text);
        router = router.route(asset.path, get(move || async move { answer }));
    }
    router.layer(from_fn_with_state(Arc::new(own), guarded))
}

/// Answers a request of the own page, refuses every other, and adds the headers to both.
async fn guarded(State(own): State<Arc<OwnNames>>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let all = |name| headers.get_all(name).iter().map(HeaderValue::as_bytes).collect::<Vec<_>>();
    let checked = own.check(&all(header::HOST), &all(header::ORIGIN), request.uri().path() == FEED);
    let mut response = match checked {
        Ok(()) => next.run(request).await,
        Err(refusal) => (StatusCode::FORBIDDEN, refusal.to_string()).into_response(),
    };
    add_headers(response.headers_mut());
    response
}

fn add_headers(headers: &mut HeaderMap) {
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
}

async fn open_feed(
    State(feed): State<Feed>,
    Extension(from): Extension<SocketAddr>,
    upgrade: WebSocketUpgrade,
) -> Response {
    let Ok(permit) = feed.readers.try_acquire_owned() else {
        let text = format!("{READERS_MAX} readers are served already; close a page of the console first");
        return (StatusCode::SERVICE_UNAVAILABLE, text).into_response();
    };
    let upgrade = upgrade.max_message_size(PAGE_MESSAGE_MAX).max_frame_size(PAGE_MESSAGE_MAX);
    upgrade.on_upgrade(move |socket| async move {
        let number = feed.number.fetch_add(1, Ordering::Relaxed) + 1;
        reader::serve(socket, feed.frames, number, from.to_string(), feed.events).await;
        drop(permit);
    })
}
