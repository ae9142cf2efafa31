//! A connection to a device.

use std::io;

use linewright_line::{REGISTER_BITS, Table};
use linewright_modbus::{Failure, Outcome, Request};
use tokio::net::TcpStream;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio_modbus::client::{Client, Context, tcp};
use tokio_modbus::{Request as Asked, Response, Slave};

use crate::Brought;
use crate::last::Last;

/// A connection, open or being made. It ends with this.
pub struct Link {
    asks: mpsc::UnboundedSender<Request>,
    task: JoinHandle<()>,
}

impl Drop for Link {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Link {
    /// Makes a connection; what it brings goes to `to`, under this device and number.
    pub fn open(
        address: &str,
        unit: u8,
        last: Last,
        (device, number): (usize, u32),
        to: mpsc::UnboundedSender<Brought>,
    ) -> Self {
        let (asks, mut asked) = mpsc::unbounded_channel();
        let address = address.to_owned();
        let task = tokio::spawn(async move {
            // Whoever waits for it may have ended.
            let bring = |outcome| _ = to.send((device, number, outcome));
            let mut context = match connect(&address, unit, &last).await {
                Ok(context) => context,
                Err(error) => return bring(Outcome::Failed(Failure::Gone(error.to_string()))),
            };
            bring(Outcome::Connected);
            while let Some(request) = asked.recv().await {
                bring(answer(&mut context, request).await);
            }
        });
        Link { asks, task }
    }

    /// Asks this, after what it was asked before.
    pub fn ask(&self, request: Request) {
        // A connection that has ended has brought that.
        let _ = self.asks.send(request);
    }
}

async fn connect(address: &str, unit: u8, last: &Last) -> io::Result<Context> {
    let stream = TcpStream::connect(address).await?;
    // A request is one small packet, and waits for nothing.
    stream.set_nodelay(true)?;
    let stream = stream.into_std()?;
    last.set(stream.try_clone()?);
    Ok(tcp::attach_slave(TcpStream::from_std(stream)?, Slave(unit)))
}

async fn answer(context: &mut Context, request: Request) -> Outcome {
    let asked = match request {
        Request::Read { table: Table::Coils, first, count } => Asked::ReadCoils(first, count),
        Request::Read { table: Table::DiscreteInputs, first, count } => Asked::ReadDiscreteInputs(first, count),
        Request::Read { table: Table::HoldingRegisters, first, count } => Asked::ReadHoldingRegisters(first, count),
        Request::Read { table: Table::InputRegisters, first, count } => Asked::ReadInputRegisters(first, count),
        Request::WriteCoils { first, count, bits } => {
            let bits: Vec<bool> = (0..count).map(|at| bits >> at & 1 == 1).collect();
            Asked::WriteMultipleCoils(first, bits.into())
        }
        Request::WriteRegisters { first, count, words } => {
            let words: Vec<u16> = (0..usize::from(count)).map(|at| (words >> (REGISTER_BITS * at)) as u16).collect();
            Asked::WriteMultipleRegisters(first, words.into())
        }
    };
    match context.call(asked).await {
        Ok(Ok(response)) => outcome(request, response),
        Ok(Err(exception)) => Outcome::Failed(Failure::Exception(exception.into())),
        Err(tokio_modbus::Error::Transport(error)) => Outcome::Failed(Failure::Gone(error.to_string())),
        Err(tokio_modbus::Error::Protocol(error)) => Outcome::Failed(Failure::Malformed(error.to_string())),
    }
}

fn outcome(request: Request, response: Response) -> Outcome {
    match (request, response) {
        (Request::Read { count, .. }, Response::ReadCoils(bits) | Response::ReadDiscreteInputs(bits)) => {
            // Bits come in whole bytes.
            match has(count, bits.len()) {
                None => {
                    let on = bits.iter().take(count.into()).enumerate().filter(|(_, on)| **on);
                    Outcome::Read(on.fold(0, |all, (at, _)| all | 1 << at))
                }
                Some(failure) => Outcome::Failed(failure),
            }
        }
        (Request::Read { count, .. }, Response::ReadHoldingRegisters(words) | Response::ReadInputRegisters(words)) => {
            match has(count, words.len()) {
                None => {
                    let words = words.iter().take(count.into()).enumerate();
                    Outcome::Read(words.fold(0, |all, (at, word)| all | u64::from(*word) << (REGISTER_BITS * at)))
                }
                Some(failure) => Outcome::Failed(failure),
            }
        }
        (Request::WriteCoils { first, count, .. }, Response::WriteMultipleCoils(at, taken))
        | (Request::WriteRegisters { first, count, .. }, Response::WriteMultipleRegisters(at, taken))
            if (first, count) == (at, taken) =>
        {
            Outcome::Written
        }
        _ => Outcome::Failed(Failure::Malformed("the answer does not belong to it".to_owned())),
    }
}

/// What is wrong if so many came where `count` were asked for.
fn has(count: u16, came: usize) -> Option<Failure> {
    let short = || Failure::Malformed(format!("wrong register map: {came} came, {count} were asked for"));
    // More than a manager asks for is nothing it could have asked.
    (came < usize::from(count) || count > 64).then(short)
}
