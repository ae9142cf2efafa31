//! Serves the frames of a page to browsers on this machine.
//!
//! [`PageServer`] listens on a loopback address and serves the page, which is part of the program, and on `/feed` a WebSocket with
//! frames. The newest frame wins: each reader has one frame under way at most, is sent the newest one when it has acknowledged that, and
//! is sent the whole page where it has missed one. A reader that acknowledges nothing for [`ACK_WITHIN`] is dropped. No reader holds up
//! another one, or the sender of the frames. Connections, readers and what a reader may send are bounded.
//!
//! It does not know what a page is about, and decides nothing of what is done at one: that goes on as a [`PageEvent`], with the number of
//! its connection. What no page sends ends its connection.
//!
//! A page of another site in the same browser is kept out by [`OwnNames`]: `Host` has to name this server, and `Origin`, where it is sent,
//! the page that it serves.
//!
//! ```
//! use linewright_console_server::PageServer;
//!
//! let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
//! runtime.block_on(async {
//!     let server = PageServer::bind("127.0.0.1:0".parse().unwrap()).await.unwrap();
//!     assert!(server.url().starts_with("http://127.0.0.1:"));
//!     // TLS and log-in are not there yet.
//!     assert!(PageServer::bind("0.0.0.0:0".parse().unwrap()).await.is_err());
//! });
//! ```

mod origin;
mod page;
mod reader;
mod server;

pub use origin::{OwnNames, RequestRefusal};
pub use page::{ASSETS, Asset};
pub use reader::{ACK_WITHIN, MESSAGES_MAX, PageEvent, PageEventKind};
pub use server::{CONNECTIONS_MAX, ListenError, NewestFrame, PageServer, READERS_MAX};
