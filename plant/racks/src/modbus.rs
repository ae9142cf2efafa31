//! The Modbus TCP servers of a rack: each address of its devices is listened at, and every request answered by the rack.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::time::Duration;

use linewright_line::Table;
use linewright_plant::{ModbusRequest, ModbusResponse};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio_modbus::client::{Client, tcp};
use tokio_modbus::server::Service;
use tokio_modbus::server::tcp::{Server, accept_tcp_connection};
use tokio_modbus::{ExceptionCode, Request, Response, Slave, SlaveRequest};

/// The function code of a fault, one of those that the specification leaves to users (MODBUS Application Protocol V1.1b3 §5). Its
/// data: index (2 bytes) and subindex of the object, a number (4 bytes), and the device's name. A real device refuses it as an
/// illegal function.
const SUFFER: u8 = 65;
/// How long its answer is waited for.
const ANSWER: Duration = Duration::from_secs(2);
/// Requests that wait for the rack.
const QUEUE: usize = 16;

/// Request to a device.
pub struct Asked {
    /// Its address and unit.
    pub at: (String, u8),
    pub request: ModbusRequest,
    /// Destination of the answer; `None` for none.
    pub reply: oneshot::Sender<Option<Result<ModbusResponse, u8>>>,
}

/// The servers of a rack. They end with this.
pub struct Servers {
    asked: mpsc::Receiver<Asked>,
    /// A sender of its own, so that the queue does not end where there is no server.
    _to: mpsc::Sender<Asked>,
    tasks: Vec<JoinHandle<()>>,
}

impl Drop for Servers {
    fn drop(&mut self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}

impl Servers {
    /// Listens at these addresses.
    ///
    /// # Errors
    /// At which it cannot be listened, and why.
    pub fn open(addresses: &[String]) -> Result<Self, (String, io::Error)> {
        let (to, asked) = mpsc::channel(QUEUE);
        let mut tasks = Vec::new();
        for address in addresses {
            let listener = listen(address).map_err(|error| (address.clone(), error))?;
            tasks.push(tokio::spawn(serve(Server::new(listener), address.clone(), to.clone())));
        }
        Ok(Servers { asked, _to: to, tasks })
    }

    /// Waits for the next request. Cancel safe.
    pub async fn next(&mut self) -> Option<Asked> {
        self.asked.recv().await
    }
}

fn listen(address: &str) -> io::Result<TcpListener> {
    let listener = std::net::TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    TcpListener::from_std(listener)
}

async fn serve(server: Server, address: String, to: mpsc::Sender<Asked>) {
    let connected = |stream: TcpStream, peer| {
        let device = ServedDevice { address: address.clone(), to: to.clone() };
        let is_open = stream.set_nodelay(true);
        std::future::ready(is_open.and_then(|()| accept_tcp_connection(stream, peer, |_| Ok(Some(device.clone())))))
    };
    let failed = |error| tracing::debug!("a Modbus connection has ended: {error}");
    if let Err(error) = server.serve(&connected, failed).await {
        tracing::warn!("the Modbus server at {address} has ended: {error}");
    }
}

/// A connection to the devices at an address.
#[derive(Clone)]
struct ServedDevice {
    address: String,
    to: mpsc::Sender<Asked>,
}

impl Service for ServedDevice {
    type Request = SlaveRequest<'static>;
    type Response = Option<Response>;
    type Exception = ExceptionCode;
    type Future = Pin<Box<dyn Future<Output = Result<Option<Response>, ExceptionCode>> + Send>>;

    fn call(&self, SlaveRequest { slave, request }: SlaveRequest<'static>) -> Self::Future {
        let (to, at) = (self.to.clone(), (self.address.clone(), slave));
        Box::pin(async move {
            let asked = request_of(&request).ok_or(ExceptionCode::IllegalFunction)?;
            let (reply, answer) = oneshot::channel();
            if to.send(Asked { at, request: asked, reply }).await.is_err() {
                return Ok(None);
            }
            match answer.await {
                Ok(Some(Ok(response))) => Ok(response_to(&request, response)),
                Ok(Some(Err(code))) => Err(ExceptionCode::new(code)),
                Ok(None) | Err(_) => Ok(None),
            }
        })
    }
}

fn request_of(request: &Request<'_>) -> Option<ModbusRequest> {
    let read = |table, first: u16, count: u16| ModbusRequest::Read { table, first, count };
    Some(match request {
        Request::ReadCoils(first, count) => read(Table::Coils, *first, *count),
        Request::ReadDiscreteInputs(first, count) => read(Table::DiscreteInputs, *first, *count),
        Request::ReadHoldingRegisters(first, count) => read(Table::HoldingRegisters, *first, *count),
        Request::ReadInputRegisters(first, count) => read(Table::InputRegisters, *first, *count),
        Request::WriteSingleCoil(at, on) => ModbusRequest::WriteCoils(*at, vec![*on]),
        Request::WriteMultipleCoils(first, bits) => ModbusRequest::WriteCoils(*first, bits.to_vec()),
        Request::WriteSingleRegister(at, word) => ModbusRequest::WriteRegisters(*at, vec![*word]),
        Request::WriteMultipleRegisters(first, words) => ModbusRequest::WriteRegisters(*first, words.to_vec()),
        Request::Custom(SUFFER, data) => {
            let (object, device) = data.split_first_chunk::<7>()?;
            let [index @ .., sub, a, b, c, d] = *object;
            ModbusRequest::Suffer {
                device: String::from_utf8(device.to_vec()).ok()?,
                object: (u16::from_be_bytes(index), sub),
                value: u32::from_be_bytes([a, b, c, d]),
            }
        }
        _ => return None,
    })
}

/// Makes the simulated Modbus device `device` at this address and unit fail: writes a number to one of the objects that a simulated
/// CANopen device has for it.
///
/// # Errors
/// Why it does not: there is none, or it has no such fault.
pub async fn suffer(at: (&str, u8), device: &str, object: (u16, u8), value: u32) -> Result<(), String> {
    let (address, unit) = at;
    let gone = |error: &dyn std::fmt::Display| format!("no simulated device answers at {address}: {error}");
    let stream = TcpStream::connect(address).await.map_err(|error| gone(&error))?;
    let mut context = tcp::attach_slave(stream, Slave(unit));
    let head = [&object.0.to_be_bytes()[..], &[object.1], &value.to_be_bytes()].concat();
    let data = [&head, device.as_bytes()].concat();
    match tokio::time::timeout(ANSWER, context.call(Request::Custom(SUFFER, data.into()))).await {
        Ok(Ok(Ok(_))) => Ok(()),
        Ok(Ok(Err(refused))) => Err(format!("{device} at {address} refuses it: {refused}")),
        Ok(Err(error)) => Err(gone(&error)),
        Err(_) => Err(gone(&format!("nothing within {} s", ANSWER.as_secs()))),
    }
}

fn response_to(request: &Request<'_>, response: ModbusResponse) -> Option<Response> {
    Some(match (request, response) {
        (Request::ReadCoils(..), ModbusResponse::Bits(bits)) => Response::ReadCoils(bits),
        (Request::ReadDiscreteInputs(..), ModbusResponse::Bits(bits)) => Response::ReadDiscreteInputs(bits),
        (Request::ReadHoldingRegisters(..), ModbusResponse::Words(words)) => Response::ReadHoldingRegisters(words),
        (Request::ReadInputRegisters(..), ModbusResponse::Words(words)) => Response::ReadInputRegisters(words),
        (Request::WriteSingleCoil(at, on), ModbusResponse::Written) => Response::WriteSingleCoil(*at, *on),
        (Request::Custom(SUFFER, _), ModbusResponse::Written) => Response::Custom(SUFFER, Default::default()),
        (Request::WriteMultipleCoils(first, bits), ModbusResponse::Written) => {
            Response::WriteMultipleCoils(*first, bits.len() as u16)
        }
        (Request::WriteSingleRegister(at, word), ModbusResponse::Written) => Response::WriteSingleRegister(*at, *word),
        (Request::WriteMultipleRegisters(first, words), ModbusResponse::Written) => {
            Response::WriteMultipleRegisters(*first, words.len() as u16)
        }
        _ => return None,
    })
}
