//! The server as browsers and others reach it: requests of the own page and of other sites, readers that are slow, silent or send what no
//! page sends.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use futures::{SinkExt, StreamExt};
use linewright_console_server::{
    ACK_WITHIN, ListenError, MESSAGES_MAX, PageEvent, PageEventKind, PageServer, READERS_MAX,
};
use linewright_console_view::{PageAct, PageFeed, PageFrame, PageOperation, PageReader};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, timeout};
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Bytes, Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

/// For a machine that is busy with other things.
const PATIENCE: Duration = Duration::from_secs(20);

type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

/// A server with its feed.
struct TestServer {
    address: SocketAddr,
    feed: PageFeed,
    frames: watch::Sender<Option<Arc<PageFrame>>>,
    events: mpsc::Receiver<PageEvent>,
}

impl TestServer {
    async fn start() -> Self {
        let server = PageServer::bind("127.0.0.1:0".parse().expect("an address")).await.expect("a free port");
        let (frames, newest) = watch::channel(None);
        let address = server.address();
        let (to, events) = mpsc::channel(1000);
        tokio::spawn(server.run(newest, to));
        TestServer { address, feed: PageFeed::default(), frames, events }
    }

    /// Publishes a page with this value.
    fn publish(&mut self, value: u64) {
        let page = json!({ "value": value, "large": "x".repeat(40_000), "same": [1, 2, 3] });
        self.frames.send_replace(Some(Arc::new(self.feed.frame_of(Duration::from_millis(value), page))));
    }

    async fn open(&self, host: Option<&str>, origin: Option<&str>) -> Result<Socket, u16> {
        let mut request = format!("ws://{}/feed", self.address).into_client_request().expect("a request");
        if let Some(host) = host {
            request.headers_mut().insert("host", host.parse().expect("a header"));
        }
        if let Some(origin) = origin {
            request.headers_mut().insert("origin", origin.parse().expect("a header"));
        }
        match connect_async(request).await {
            Ok((socket, _)) => Ok(socket),
            Err(Error::Http(response)) => Err(response.status().as_u16()),
            Err(other) => panic!("{other}"),
        }
    }

    /// A reader as the page opens it.
    async fn reader(&self) -> TestReader {
        let origin = format!("http://{}", self.address);
        let socket = self.open(None, Some(&origin)).await.expect("it is served");
        let mut reader = TestReader { socket, page: PageReader::default(), connection: 0 };
        let greeting: Value = serde_json::from_str(&reader.text().await).expect("JSON");
        reader.connection = greeting["connection"].as_u64().expect("its number");
        reader
    }

    /// The next event of this connection.
    async fn event(&mut self, connection: u64) -> PageEventKind {
        loop {
            let event = timeout(PATIENCE, self.events.recv()).await.expect("an event").expect("it serves");
            if event.connection == connection {
                return event.what;
            }
        }
    }

    /// The answer to a request that is written out.
    async fn raw(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.address).await.expect("a connection");
        stream.write_all(request.as_bytes()).await.expect("sent");
        let mut answer = Vec::new();
        let read = timeout(PATIENCE, stream.read_to_end(&mut answer)).await;
        read.expect("it is answered").expect("it is read");
        String::from_utf8_lossy(&answer).into_owned()
    }
}

struct TestReader {
    socket: Socket,
    page: PageReader,
    connection: u64,
}

impl TestReader {
    async fn text(&mut self) -> String {
        let message =
            timeout(PATIENCE, self.socket.next()).await.expect("one comes").expect("open").expect("a message");
        message.into_text().expect("text").to_string()
    }

    /// The next frame; gives its number and its length. Not acknowledged yet.
    async fn frame(&mut self) -> (u64, usize) {
        let text = self.text().await;
        (self.page.take(&text).expect("a frame that fits"), text.len())
    }

    async fn acknowledge(&mut self, sequence: u64) {
        self.socket.send(Message::text(sequence.to_string())).await.expect("sent");
    }

    async fn next(&mut self) -> u64 {
        let (sequence, _) = self.frame().await;
        self.acknowledge(sequence).await;
        sequence
    }

    fn value(&self) -> u64 {
        self.page.page()["value"].as_u64().expect("a page")
    }

    async fn ends(&mut self) {
        let end = async { while matches!(self.socket.next().await, Some(Ok(_))) {} };
        timeout(PATIENCE, end).await.expect("the connection ends");
    }
}

#[tokio::test]
async fn the_page_is_served_to_its_own_names_and_to_no_other() {
    let served = TestServer::start().await;
    let port = served.address.port();
    let get = |host: &str, more: &str| format!("GET / HTTP/1.1\r\n{host}Connection: close\r\n{more}\r\n");
    for name in ["127.0.0.1", "localhost", "[::1]", "LOCALHOST"] {
        let answer = served.raw(&get(&format!("Host: {name}:{port}\r\n"), "")).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{name}: {answer}");
    }
    let own = format!("Host: 127.0.0.1:{port}\r\n");
    for (host, more) in [
        (format!("Host: evil.example:{port}\r\n"), String::new()),
        ("Host: 127.0.0.1:1\r\n".to_owned(), String::new()),
        ("Host: 127.0.0.1\r\n".to_owned(), String::new()),
        (format!("{own}Host: evil.example\r\n"), String::new()),
        (own.clone(), "Origin: http://evil.example\r\n".to_owned()),
        (own.clone(), format!("Origin: https://127.0.0.1:{port}\r\n")),
        (own.clone(), "Origin: null\r\n".to_owned()),
        (own.clone(), format!("Origin: http://127.0.0.1:{port}\r\nOrigin: http://evil.example\r\n")),
    ] {
        let answer = served.raw(&get(&host, &more)).await;
        assert!(answer.starts_with("HTTP/1.1 403"), "{host}{more}: {answer}");
    }
    let same = served.raw(&get(&own, &format!("Origin: http://127.0.0.1:{port}\r\n"))).await;
    assert!(same.starts_with("HTTP/1.1 200"), "{same}");
}

#[tokio::test]
async fn every_answer_has_the_headers_that_keep_others_out() {
    let served = TestServer::start().await;
    let port = served.address.port();
    for (path, host) in
        [("/", "127.0.0.1"), ("/page.js", "127.0.0.1"), ("/nothing", "127.0.0.1"), ("/", "evil.example")]
    {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: close\r\n\r\n");
        let answer = served.raw(&request).await.to_ascii_lowercase();
        let policy = answer.lines().find(|line| line.starts_with("content-security-policy:")).unwrap_or_default();
        assert!(policy.contains("default-src 'none'") && policy.contains("script-src 'self';"), "{path}: {answer}");
        assert!(!policy.contains("unsafe"), "{policy}");
        for header in ["x-content-type-options: nosniff", "cache-control: no-store", "x-frame-options: deny"] {
            assert!(answer.contains(header), "{path} {host}: {header}: {answer}");
        }
    }
}

#[tokio::test]
async fn a_feed_is_opened_by_the_own_page_alone() {
    let mut served = TestServer::start().await;
    served.publish(1);
    let own = format!("http://{}", served.address);
    assert_eq!(served.open(None, None).await.err(), Some(403), "a program without an origin");
    assert_eq!(served.open(None, Some("http://evil.example")).await.err(), Some(403));
    let rebound = format!("evil.example:{}", served.address.port());
    assert_eq!(served.open(Some(&rebound), Some(&format!("http://{rebound}"))).await.err(), Some(403));
    assert_eq!(served.open(Some(&rebound), Some(&own)).await.err(), Some(403));
    assert!(served.open(None, Some(&own)).await.is_ok());
}

#[tokio::test]
async fn a_reader_is_sent_changes_and_the_whole_where_it_has_missed_a_frame() {
    let mut served = TestServer::start().await;
    let mut reader = served.reader().await;
    served.publish(1);
    let (first, whole) = reader.frame().await;
    reader.acknowledge(first).await;
    served.publish(2);
    let (second, changes) = reader.frame().await;
    assert!(second == first + 1 && changes < 200 && whole > 40_000, "{changes} of {whole}");
    // Without its acknowledgement it is sent nothing more, whatever is published.
    (3..40).for_each(|value| served.publish(value));
    assert!(timeout(Duration::from_millis(300), reader.socket.next()).await.is_err(), "one frame is under way at most");
    reader.acknowledge(second).await;
    let (newest, again) = reader.frame().await;
    assert!(again > 40_000, "the whole page");
    assert_eq!((newest, reader.value()), (39, 39), "the newest, and none of those before");
}

#[tokio::test]
async fn a_reader_that_does_not_read_delays_no_other_and_is_dropped() {
    let mut served = TestServer::start().await;
    let silent: Vec<TestReader> = futures::future::join_all((0..20).map(|_| served.reader())).await;
    let mut reader = served.reader().await;
    let begin = Instant::now();
    for value in 1..=20 {
        served.publish(value);
        reader.next().await;
        assert_eq!(reader.value(), value);
    }
    assert!(begin.elapsed() < ACK_WITHIN, "twenty frames took {:?}", begin.elapsed());
    for mut silent in silent {
        silent.ends().await;
    }
    assert!(begin.elapsed() >= ACK_WITHIN, "they are given their time");
    served.publish(21);
    assert_eq!(reader.next().await, 21);
}

#[tokio::test]
async fn what_no_page_sends_ends_that_connection_alone() {
    let mut served = TestServer::start().await;
    served.publish(1);
    let mut good = served.reader().await;
    good.next().await;
    let pings = || (0..=MESSAGES_MAX).map(|_| Message::Ping(Bytes::new()));
    for bad in [
        vec![Message::text("x".repeat(100_000))],
        vec![Message::text("x")],
        vec![Message::text("2")],
        vec![Message::text("-1")],
        vec![Message::text(r#"{"seen_ms":1,"act":"explode"}"#)],
        vec![Message::text(r#"{"seen_ms":1,"act":{"beat":{"number":1,"more":2}}}"#)],
        vec![Message::text(r#"{"act":{"beat":{"number":1}}}"#)],
        vec![Message::text(r#"{"seen_ms":1,"act":{"beat":{"number":-1}}}"#)],
        vec![Message::binary(vec![1])],
        pings().collect(),
    ] {
        let mut reader = served.reader().await;
        reader.frame().await;
        for message in bad {
            // The other side may have ended by now.
            let _ = reader.socket.send(message).await;
        }
        reader.ends().await;
    }
    served.publish(2);
    assert_eq!(good.next().await, 2);
}

#[tokio::test]
async fn one_reader_more_than_there_may_be_is_refused() {
    let served = TestServer::start().await;
    let mut readers = Vec::new();
    for _ in 0..READERS_MAX {
        readers.push(served.reader().await);
    }
    let origin = format!("http://{}", served.address);
    assert_eq!(served.open(None, Some(&origin)).await.err(), Some(503));
    readers.pop();
    let is_free = async {
        while served.open(None, Some(&origin)).await.is_err() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    timeout(PATIENCE, is_free).await.expect("the place of one that has gone is free");
}

#[tokio::test]
async fn readers_end_with_the_feed() {
    let mut served = TestServer::start().await;
    served.publish(1);
    let mut reader = served.reader().await;
    reader.next().await;
    drop(served);
    reader.ends().await;
}

#[tokio::test]
async fn an_address_for_other_hosts_and_one_in_use_are_refused_with_the_reason() {
    let refused = |address: String| async move { PageServer::bind(address.parse().expect("an address")).await.err() };
    for address in ["0.0.0.0:0", "192.0.2.1:80", "[::]:0"] {
        let error = refused(address.to_owned()).await.expect("it is refused");
        assert!(
            matches!(error, ListenError::NotLoopback(_)) && error.to_string().contains("TLS and log-in"),
            "{error}"
        );
    }
    let served = TestServer::start().await;
    let error = refused(served.address.to_string()).await.expect("it is refused");
    assert!(matches!(error, ListenError::InUse(_)) && error.to_string().contains("--listen"), "{error}");
}

#[tokio::test]
async fn what_is_done_at_a_page_comes_with_its_connection_between_its_begin_and_its_end() {
    let mut served = TestServer::start().await;
    served.publish(1);
    let (mut first, mut second) = (served.reader().await, served.reader().await);
    assert_ne!(first.connection, second.connection);
    first.next().await;
    let beat = |number| PageOperation { seen_ms: 7, act: PageAct::Beat { number }, step: None };
    for (is_first, number) in [(false, 1), (true, 2), (false, 3)] {
        let text = serde_json::to_string(&beat(number)).expect("JSON");
        let reader = if is_first { &mut first } else { &mut second };
        reader.socket.send(Message::text(text)).await.expect("sent");
    }
    assert!(
        matches!(served.event(first.connection).await, PageEventKind::Opened(from) if from.starts_with("127.0.0.1:"))
    );
    assert_eq!(served.event(first.connection).await, PageEventKind::Operated(beat(2)));
    // Cut off without a word of parting.
    let number = first.connection;
    drop(first);
    assert_eq!(served.event(number).await, PageEventKind::Closed);
}
