//! One reader of frames: the newest frame, its acknowledgement, the next one; and what is done at its page.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use futures::stream::SplitSink;
use futures::{SinkExt, StreamExt};
use linewright_console_view::{ConnectionNumber, PageFrame, PageMessage, PageOperation};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until, timeout_at};

use crate::server::NewestFrame;

/// Time in which a reader acknowledges a frame. One that takes longer is dropped, and may connect again.
pub const ACK_WITHIN: Duration = Duration::from_secs(5);

/// Most messages of a reader between two frames, pings among them.
pub const MESSAGES_MAX: u32 = 16;

/// What comes from a page.
#[derive(Debug, PartialEq, Eq)]
pub struct PageEvent {
    /// Never that of an earlier connection.
    pub connection: ConnectionNumber,
    pub what: PageEventKind,
}

/// What has happened at a connection.
#[derive(Debug, PartialEq, Eq)]
pub enum PageEventKind {
    /// It is there, from this address. Comes first.
    Opened(String),
    Operated(PageOperation),
    /// It is there no more. Comes last.
    Closed,
}

/// A reader is not served any more: it has gone, does not read, has sent what no page sends, or there are no more frames.
#[derive(Debug)]
struct ReaderEnded;

/// A connection that frames are sent to.
struct FrameReader {
    connection: ConnectionNumber,
    to: SplitSink<WebSocket, Message>,
    events: mpsc::Sender<PageEvent>,
    /// The newest frame that it has acknowledged.
    last: Option<u64>,
    /// The frame that it has to acknowledge, and until when.
    under_way: Option<(u64, Instant)>,
    /// Messages that it may still send before the next frame.
    room: u32,
}

/// Serves a reader until it goes, does not read, or sends what no page sends.
pub async fn serve(
    socket: WebSocket,
    frames: NewestFrame,
    connection: ConnectionNumber,
    address: String,
    events: mpsc::Sender<PageEvent>,
) {
    let event = |what| PageEvent { connection, what };
    if events.send(event(PageEventKind::Opened(address))).await.is_err() {
        return;
    }
    let (to, from) = socket.split();
    let reader =
        FrameReader { connection, to, events: events.clone(), last: None, under_way: None, room: MESSAGES_MAX };
    let _ = reader.run(from, frames).await;
    let _ = events.send(event(PageEventKind::Closed)).await;
}

impl FrameReader {
    async fn run(
        mut self,
        mut from: futures::stream::SplitStream<WebSocket>,
        mut frames: NewestFrame,
    ) -> Result<(), ReaderEnded> {
        // By this a page knows whether it has control.
        let greeting = format!(r#"{{"connection":{}}}"#, self.connection);
        self.send(greeting, Instant::now() + ACK_WITHIN).await?;
        loop {
            let end = self.under_way.map(|(_, end)| end);
            if end.is_none() {
                self.send_newer(&mut frames).await?;
            }
            let end = self.under_way.map(|(_, end)| end);
            tokio::select! {
                biased;
                message = from.next() => self.take(message)?,
                changed = frames.changed(), if end.is_none() => changed.map_err(|_| ReaderEnded)?,
                () = sleep_until(end.unwrap_or_else(Instant::now)), if end.is_some() => return Err(ReaderEnded),
            }
        }
    }

    /// Sends the newest frame, if it is newer than the last.
    async fn send_newer(&mut self, frames: &mut NewestFrame) -> Result<(), ReaderEnded> {
        let newest: Option<Arc<PageFrame>> = frames.borrow_and_update().clone();
        let Some(frame) = newest.filter(|frame| Some(frame.sequence()) != self.last) else { return Ok(()) };
        let end = Instant::now() + ACK_WITHIN;
        self.room = MESSAGES_MAX;
        self.under_way = Some((frame.sequence(), end));
        self.send(frame.text_after(self.last).to_owned(), end).await
    }

    async fn send(&mut self, text: String, end: Instant) -> Result<(), ReaderEnded> {
        match timeout_at(end, self.to.send(Message::text(text))).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(ReaderEnded),
        }
    }

    /// Takes what has come. A ping is answered already.
    fn take(&mut self, message: Option<Result<Message, axum::Error>>) -> Result<(), ReaderEnded> {
        let Some(Ok(message)) = message else { return Err(ReaderEnded) };
        self.room = self.room.checked_sub(1).ok_or(ReaderEnded)?;
        let text = match message {
            Message::Text(text) => text,
            Message::Ping(_) | Message::Pong(_) => return Ok(()),
            Message::Binary(_) | Message::Close(_) => return Err(ReaderEnded),
        };
        match PageMessage::parse(&text).map_err(|_| ReaderEnded)? {
            PageMessage::Acknowledged(number) => {
                let (sequence, _) = self.under_way.take().filter(|(of, _)| *of == number).ok_or(ReaderEnded)?;
                self.last = Some(sequence);
                Ok(())
            }
            PageMessage::Operated(operation) => {
                let event = PageEvent { connection: self.connection, what: PageEventKind::Operated(operation) };
                // One that is not taken in is not kept for later.
                self.events.try_send(event).map_err(|_| ReaderEnded)
            }
        }
    }
}
