//! Chromium, driven by its own driver, whose protocol (W3C WebDriver) is JSON over HTTP; of it only what is needed here. Without them
//! (Debian: `chromium`, `chromium-driver`) a test prints SKIPPED.

use std::io::Write;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep, timeout};

/// For a machine that is busy with other things.
pub const PATIENCE: Duration = Duration::from_secs(40);

/// A browser with its driver; both end with it.
pub struct Browser {
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
    pub async fn open() -> Result<Self, String> {
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
    pub async fn open_or_skip() -> Option<Self> {
        let opened = Browser::open().await;
        opened.map_err(|why| println!("SKIPPED: no Chromium with its driver here ({why})")).ok()
    }

    /// A request of the protocol; gives its value.
    pub async fn ask(&self, method: &str, path: &str, asked: &Value) -> Result<Value, String> {
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

    pub async fn script(&self, script: &str) -> Value {
        let path = format!("/session/{}/execute/sync", self.session);
        self.ask("POST", &path, &json!({ "script": script, "args": [] })).await.expect("it runs")
    }

    pub async fn visit(&self, url: &str) {
        let path = format!("/session/{}/url", self.session);
        self.ask("POST", &path, &json!({ "url": url })).await.expect("it is loaded");
    }

    /// Waits until a condition of the page holds.
    pub async fn wait(&self, condition: &str) {
        let end = Instant::now() + PATIENCE;
        while self.script(&format!("return Boolean({condition})")).await != true {
            assert!(Instant::now() < end, "{condition}: {}", self.script("return document.body.innerText").await);
            sleep(Duration::from_millis(30)).await;
        }
    }
}

/// Acts of a pointer or the keyboard, as WebDriver takes them.
impl Browser {
    pub async fn act(&self, of: &Value) {
        let path = format!("/session/{}/actions", self.session);
        self.ask("POST", &path, &json!({ "actions": [of] })).await.expect("it is done");
    }

    pub async fn pointer(&self, acts: Value) {
        self.act(
            &json!({ "type": "pointer", "id": "mouse", "parameters": { "pointerType": "mouse" }, "actions": acts }),
        )
        .await;
    }

    /// The middle of a button.
    pub async fn middle(&self, key: &str) -> (i64, i64) {
        let script = format!(
            "const of = document.querySelector('[data-key=\"{key}\"]'); of.scrollIntoView({{ block: 'center' }}); \
             const box = of.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]"
        );
        let at = self.script(&script).await;
        (at[0].as_f64().expect("a number") as i64, at[1].as_f64().expect("a number") as i64)
    }

    pub async fn press(&self, (x, y): (i64, i64)) {
        self.pointer(json!([{ "type": "pointerMove", "x": x, "y": y }, { "type": "pointerDown", "button": 0 }])).await;
    }

    pub async fn let_go(&self) {
        self.pointer(json!([{ "type": "pointerUp", "button": 0 }])).await;
    }
}

/// The tests of a page by its style: it is grey, its mode is struck through, and the time of the loss is shown.
pub const IS_LOST: &str = "document.documentElement.classList.contains('lost') && document.getElementById('lost') \
                       && getComputedStyle(document.getElementById('mode')).textDecorationLine === 'line-through' \
                       && getComputedStyle(document.body).filter === 'grayscale(1)'";
pub const IS_LIVE: &str = "!document.documentElement.classList.contains('lost') && !document.getElementById('lost') \
                       && getComputedStyle(document.getElementById('mode')).textDecorationLine === 'none'";
