//! A connection to a device.

use std::io;
use std::time::Duration;

use linewright_line::{REGISTER_BITS, Table};
use linewright_modbus::{LinkOutcome, ModbusFailure, ModbusRequest};
use socket2::SockRef;
use tokio::net::TcpStream;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio_modbus::client::{Client, Context, tcp};
use tokio_modbus::{Request as Asked, Response, Slave};

use crate::Brought;
use crate::last::LastOrder;

/// A connection, open or being made. It ends with this.
pub struct Connection {
    asks: mpsc::UnboundedSender<ModbusRequest>,
    task: JoinHandle<()>,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Connection {
    /// Makes a connection; what it brings goes to `to`, under this device and number.
    pub fn open(
        (address, unit, timeout): (&str, u8, Duration),
        last: LastOrder,
        (device, number): (usize, u32),
        to: mpsc::UnboundedSender<Brought>,
    ) -> Self {
        let (asks, mut asked) = mpsc::unbounded_channel();
        let address = address.to_owned();
        let task = tokio::spawn(async move {
            // The receiver may have ended.
            let bring = |outcome| _ = to.send((device, number, outcome));
            let mut context = match connect(&address, unit, timeout, &last).await {
                Ok(context) => context,
                Err(error) => return bring(LinkOutcome::Failed(ModbusFailure::Gone(error.to_string()))),
            };
            bring(LinkOutcome::Connected);
            while let Some(request) = asked.recv().await {
                bring(answer(&mut context, request).await);
            }
        });
        Connection { asks, task }
    }

    /// Sends this request, after the earlier ones.
    pub fn ask(&self, request: ModbusRequest) {
        // A connection that has ended has brought that.
        let _ = self.asks.send(request);
    }
}

async fn connect(address: &str, unit: u8, timeout: Duration, last: &LastOrder) -> io::Result<Context> {
    let stream = TcpStream::connect(address).await?;
    // A request is one small packet, and waits for nothing.
    stream.set_nodelay(true)?;
    // A request that was not acknowledged in time must not be sent again by the operating system later, when the connection is
    // long given up: outputs would come on after a loss.
    SockRef::from(&stream).set_tcp_user_timeout(Some(timeout))?;
    let stream = stream.into_std()?;
    last.set(stream.try_clone()?);
    Ok(tcp::attach_slave(TcpStream::from_std(stream)?, Slave(unit)))
}

async fn answer(context: &mut Context, request: ModbusRequest) -> LinkOutcome {
    let asked = match request {
        ModbusRequest::Read { table: Table::Coils, first, count } => Asked::ReadCoils(first, count),
        ModbusRequest::Read { table: Table::DiscreteInputs, first, count } => Asked::ReadDiscreteInputs(first, count),
        ModbusRequest::Read { table: Table::HoldingRegisters, first, count } => {
            Asked::ReadHoldingRegisters(first, count)
        }
        ModbusRequest::Read { table: Table::InputRegisters, first, count } => Asked::ReadInputRegisters(first, count),
        ModbusRequest::WriteCoils { first, count, bits } => {
            let bits: Vec<bool> = (0..count).map(|at| bits >> at & 1 == 1).collect();
            Asked::WriteMultipleCoils(first, bits.into())
        }
        ModbusRequest::WriteRegisters { first, count, words } => {
            let words: Vec<u16> = (0..usize::from(count)).map(|at| (words >> (REGISTER_BITS * at)) as u16).collect();
            Asked::WriteMultipleRegisters(first, words.into())
        }
    };
    match context.call(asked).await {
        Ok(Ok(response)) => outcome(request, response),
        Ok(Err(exception)) => LinkOutcome::Failed(ModbusFailure::Exception(exception.into())),
        Err(tokio_modbus::Error::Transport(error)) => LinkOutcome::Failed(ModbusFailure::Gone(error.to_string())),
        Err(tokio_modbus::Error::Protocol(error)) => LinkOutcome::Failed(ModbusFailure::Malformed(error.to_string())),
    }
}

fn outcome(request: ModbusRequest, response: Response) -> LinkOutcome {
    match (request, response) {
        (ModbusRequest::Read { count, .. }, Response::ReadCoils(bits) | Response::ReadDiscreteInputs(bits)) => {
            // Bits come in whole bytes.
            match has(count, usize::from(count).next_multiple_of(8), bits.len()) {
                None => {
                    let on = bits.iter().take(count.into()).enumerate().filter(|(_, on)| **on);
                    LinkOutcome::Read(on.fold(0, |all, (at, _)| all | 1 << at))
                }
                Some(failure) => LinkOutcome::Failed(failure),
            }
        }
        (
            ModbusRequest::Read { count, .. },
            Response::ReadHoldingRegisters(words) | Response::ReadInputRegisters(words),
        ) => match has(count, usize::from(count).min(4), words.len()) {
            None => {
                let words = words.iter().take(count.into()).enumerate();
                LinkOutcome::Read(words.fold(0, |all, (at, word)| all | u64::from(*word) << (REGISTER_BITS * at)))
            }
            Some(failure) => LinkOutcome::Failed(failure),
        },
        (ModbusRequest::WriteCoils { first, count, .. }, Response::WriteMultipleCoils(at, taken))
        | (ModbusRequest::WriteRegisters { first, count, .. }, Response::WriteMultipleRegisters(at, taken))
            if (first, count) == (at, taken) =>
        {
            LinkOutcome::Written
        }
        _ => LinkOutcome::Failed(ModbusFailure::OtherAnswer),
    }
}

/// The fault if `came` is not the `count` requested; up to `most` may come with padding.
fn has(count: u16, most: usize, came: usize) -> Option<ModbusFailure> {
    let wrong = || ModbusFailure::Count { came, count };
    // More than 64 was never requested.
    (came < usize::from(count) || came > most || most > 64).then(wrong)
}
