//! Reading and writing one object of one device, for tools.
//!
//! A tool takes part in the bus like `cansend` does, beside the manager. It waits for its own answers and drops every
//! other frame, so it needs a [`Bus`] of its own.

use linewright_canopen::codec::{CanopenMessage, NodeId};
use linewright_canopen::sdo::wire::SdoBytes;
use linewright_canopen::sdo::{ObjectId, SdoClient, TransferError, TransferOptions, TransferProgress};

use crate::bus::{Bus, BusError};
use crate::clock::Clock;

/// Why an object was not read or written.
#[derive(Debug)]
pub enum SdoError {
    /// The transfer has failed.
    Transfer {
        node: NodeId,
        /// The object, and what went wrong with it.
        error: TransferError,
    },
    /// The bus is gone.
    Bus(BusError),
}

impl From<BusError> for SdoError {
    fn from(error: BusError) -> Self {
        SdoError::Bus(error)
    }
}

/// Reads an object of `node`, of any length up to [`TransferOptions::len_max`].
pub async fn read(
    bus: &mut Bus,
    node: NodeId,
    object: ObjectId,
    options: TransferOptions,
) -> Result<Vec<u8>, SdoError> {
    transfer(bus, node, SdoClient::upload(object, options)).await
}

/// Writes an object of `node`, with data of any length.
pub async fn write(
    bus: &mut Bus,
    node: NodeId,
    object: ObjectId,
    data: &[u8],
    options: TransferOptions,
) -> Result<(), SdoError> {
    transfer(bus, node, SdoClient::download(object, data, options)).await.map(|_| ())
}

/// Carries out a transfer. Dropped in between, it leaves the device waiting, which ends the transfer by itself.
async fn transfer(bus: &mut Bus, node: NodeId, mut client: SdoClient) -> Result<Vec<u8>, SdoError> {
    let clock = Clock::start();
    let mut out: Vec<SdoBytes> = Vec::new();
    client.start(clock.now(), &mut out);
    loop {
        for raw in out.drain(..) {
            bus.send(&CanopenMessage::SdoRequest { node, raw }.encode());
        }
        let progress = tokio::select! {
            biased;
            frame = bus.recv() => match CanopenMessage::decode(&frame?) {
                Ok(CanopenMessage::SdoResponse { node: from, raw }) if from == node => {
                    client.handle(clock.now(), &raw, &mut out)
                }
                // A busy bus must not keep the transfer from giving up.
                _ => client.poll(clock.now(), &mut out),
            },
            () = clock.sleep_until(client.next_deadline()) => client.poll(clock.now(), &mut out),
        };
        if let TransferProgress::Done(result) = progress {
            for raw in out.drain(..) {
                bus.send(&CanopenMessage::SdoRequest { node, raw }.encode());
            }
            return result.map_err(|error| SdoError::Transfer { node, error });
        }
    }
}
