//! One reader of frames: the newest frame, its acknowledgement, the next one.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use linewright_console_view::PageFrame;
use tokio::time::{Instant, timeout_at};

use crate::server::NewestFrame;

/// Time in which a reader acknowledges a frame. One that takes longer is dropped, and may connect again.
pub const ACK_WITHIN: Duration = Duration::from_secs(5);

/// Most bytes of what a reader sends: the number of a frame, or a ping.
pub const MESSAGE_MAX: usize = 128;

/// Most messages of a reader between two frames, pings among them.
pub const MESSAGES_MAX: u32 = 16;

/// A reader is not served any more: it has gone, does not read, has sent what no page sends, or there are no more frames.
#[derive(Debug)]
struct ReaderEnded;

/// Serves a reader until it goes, or does not read.
pub async fn serve(mut socket: WebSocket, mut frames: NewestFrame) {
    let mut last = None;
    loop {
        let mut room = MESSAGES_MAX;
        let Ok(frame) = newer(&mut socket, &mut frames, last, &mut room).await else { return };
        let end = Instant::now() + ACK_WITHIN;
        let text = Message::text(frame.text_after(last));
        if !matches!(timeout_at(end, socket.send(text)).await, Ok(Ok(()))) {
            return;
        }
        if !matches!(timeout_at(end, acknowledged(&mut socket, frame.sequence(), &mut room)).await, Ok(Ok(()))) {
            return;
        }
        last = Some(frame.sequence());
    }
}

/// Waits for a frame that is newer than `last`.
async fn newer(
    socket: &mut WebSocket,
    frames: &mut NewestFrame,
    last: Option<u64>,
    room: &mut u32,
) -> Result<Arc<PageFrame>, ReaderEnded> {
    loop {
        let newest = frames.borrow_and_update().clone();
        if let Some(frame) = newest.filter(|frame| Some(frame.sequence()) != last) {
            return Ok(frame);
        }
        tokio::select! {
            changed = frames.changed() => changed.map_err(|_| ReaderEnded)?,
            // Nothing is under way that could be acknowledged.
            heard = heard(socket, room) => if heard?.is_some() {
                return Err(ReaderEnded);
            },
        }
    }
}

/// Waits until this frame is acknowledged.
async fn acknowledged(socket: &mut WebSocket, sequence: u64, room: &mut u32) -> Result<(), ReaderEnded> {
    loop {
        match heard(socket, room).await? {
            Some(number) if number == sequence => return Ok(()),
            Some(_) => return Err(ReaderEnded),
            None => {}
        }
    }
}

/// The next message: the number that it acknowledges, none of a ping, which is answered already.
async fn heard(socket: &mut WebSocket, room: &mut u32) -> Result<Option<u64>, ReaderEnded> {
    let Some(Ok(message)) = socket.recv().await else { return Err(ReaderEnded) };
    *room = room.checked_sub(1).ok_or(ReaderEnded)?;
    match message {
        Message::Text(text) => text.parse().map(Some).map_err(|_| ReaderEnded),
        Message::Ping(_) | Message::Pong(_) => Ok(None),
        Message::Binary(_) | Message::Close(_) => Err(ReaderEnded),
    }
}
