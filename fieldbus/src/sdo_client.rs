//! Reading and writing one object of one device, for tools.
//!
//! A tool takes part in the bus like `cansend` does, beside the manager. It waits for its own answer and drops every
//! other frame, so it wants a [`Bus`] of its own.

use std::time::Duration;

use thiserror::Error;

use crate::bus::Bus;
use crate::codec::{Abort, Message, NodeId, SdoData, SdoRequest, SdoResponse};

/// Why an object was not read or written.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SdoError {
    /// The device refuses.
    #[error("node {node} refuses object {index:04X}h:{sub:02X}: {code}")]
    Aborted {
        /// The device.
        node: NodeId,
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
        /// Its reason.
        code: Abort,
    },
    /// No answer came.
    #[error("node {node} did not answer for object {index:04X}h:{sub:02X} within {} ms", waited.as_millis())]
    Timeout {
        /// The device.
        node: NodeId,
        /// Index of the object.
        index: u16,
        /// Subindex.
        sub: u8,
        /// For how long.
        waited: Duration,
    },
}

/// Writes an object of `node`.
pub async fn write(
    bus: &mut Bus,
    node: NodeId,
    index: u16,
    sub: u8,
    data: SdoData,
    timeout: Duration,
) -> Result<(), SdoError> {
    ask(bus, node, (index, sub), SdoRequest::Download { index, sub, data }, timeout).await.map(|_| ())
}

/// Reads an object of `node`.
pub async fn read(bus: &mut Bus, node: NodeId, index: u16, sub: u8, timeout: Duration) -> Result<SdoData, SdoError> {
    let data = ask(bus, node, (index, sub), SdoRequest::Upload { index, sub }, timeout).await?;
    // `ask` returns only what answers the request: an upload's answer has data.
    data.ok_or(SdoError::Aborted { node, index, sub, code: Abort::COMMAND })
}

async fn ask(
    bus: &mut Bus,
    node: NodeId,
    (index, sub): (u16, u8),
    request: SdoRequest,
    timeout: Duration,
) -> Result<Option<SdoData>, SdoError> {
    bus.send(&Message::SdoRequest { node, request }.encode());
    let answer = async {
        loop {
            match Message::decode(&bus.recv().await) {
                Ok(Message::SdoResponse { node: from, response })
                    if from == node && response.object() == (index, sub) =>
                {
                    match response {
                        SdoResponse::Downloaded { .. } => return Ok(None),
                        SdoResponse::Uploaded { data, .. } => return Ok(Some(data)),
                        SdoResponse::Aborted { code, .. } => {
                            return Err(SdoError::Aborted { node, index, sub, code });
                        }
                    }
                }
                _ => {}
            }
        }
    };
    let late = SdoError::Timeout { node, index, sub, waited: timeout };
    tokio::time::timeout(timeout, answer).await.unwrap_or(Err(late))
}
