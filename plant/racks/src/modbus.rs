//! The Modbus TCP servers of a rack: each address of its devices is listened at, and every request answered by the rack.

use std::future::Future;
use std::io;
use std::pin::Pin;
use std::time::Duration;

use linewright_line::Table;
use linewright_plant::{FaultWrite, ModbusRequest, ModbusResponse};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio_modbus::client::{Client, tcp};
use tokio_modbus::prelude::{ConformityLevel, DeviceIdObject, ReadCode, ReadDeviceIdentificationResponse};
use tokio_modbus::server::Service;
use tokio_modbus::server::tcp::{Server, accept_tcp_connection};
use tokio_modbus::{ExceptionCode, Request, Response, Slave, SlaveRequest};

/// The function code of a fault, one of those that the specification leaves to users (MODBUS Application Protocol V1.1b3 §5). Its
/// data: index (2 bytes) and subindex of the object, a number (4 bytes), and the device's name. To a real device it may mean
/// anything: it is sent only to an address where devices are simulated.
const FAULT_FUNCTION: u8 = 65;
/// Product code in the identification (§6.21, function 43) of each simulated device.
const PRODUCT: &[u8] = b"Linewright simulated device";
/// The number of the product code there.
const PRODUCT_CODE: u8 = 1;
/// How long its answer is waited for.
const ANSWER: Duration = Duration::from_secs(2);
/// Requests that wait for the rack.
const QUEUE: usize = 16;

/// What comes to a rack's servers. The answer is an exception's code where it is refused, `None` for none.
pub enum Asked {
    /// A request to the device at this address and unit.
    Request { at: (String, u8), request: ModbusRequest, reply: oneshot::Sender<Option<Result<ModbusResponse, u8>>> },
    /// A fault for the device of this name: an object of a simulated CANopen device, and a number.
    Fault { at: (String, u8), device: String, fault: FaultWrite, reply: oneshot::Sender<Option<Result<(), u8>>> },
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
            match &request {
                Request::ReadDeviceIdentification(code, _) => return Ok(Some(identification(*code))),
                Request::Custom(FAULT_FUNCTION, data) => {
                    let (device, fault) = fault_of(data).ok_or(ExceptionCode::IllegalDataValue)?;
                    let (reply, answer) = oneshot::channel();
                    let done = answered(&to, Asked::Fault { at, device, fault, reply }, answer).await?;
                    return Ok(done.map(|()| Response::Custom(FAULT_FUNCTION, Default::default())));
                }
                _ => {}
            }
            let asked = request_of(&request).ok_or(ExceptionCode::IllegalFunction)?;
            let (reply, answer) = oneshot::channel();
            let response = answered(&to, Asked::Request { at, request: asked, reply }, answer).await?;
            Ok(response.and_then(|response| response_to(&request, response)))
        })
    }
}

/// The rack's answer, `None` for none.
async fn answered<T>(
    to: &mpsc::Sender<Asked>,
    asked: Asked,
    answer: oneshot::Receiver<Option<Result<T, u8>>>,
) -> Result<Option<T>, ExceptionCode> {
    if to.send(asked).await.is_err() {
        return Ok(None);
    }
    answer.await.ok().flatten().transpose().map_err(ExceptionCode::new)
}

/// The device's name, and the fault in the data of function 65.
fn fault_of(data: &[u8]) -> Option<(String, FaultWrite)> {
    let (object, device) = data.split_first_chunk::<7>()?;
    let [index @ .., sub, a, b, c, d] = *object;
    let fault = ((u16::from_be_bytes(index), sub), u32::from_be_bytes([a, b, c, d]));
    Some((String::from_utf8(device.to_vec()).ok()?, fault))
}

/// Identification of every simulated device, also of one that is silent.
fn identification(read_code: ReadCode) -> Response {
    let object = |id, value: &'static [u8]| DeviceIdObject { id, value: value.into() };
    Response::ReadDeviceIdentification(ReadDeviceIdentificationResponse {
        read_code,
        conformity_level: ConformityLevel::BasicIdentificationStreamOnly,
        more_follows: false,
        next_object_id: 0,
        device_id_objects: vec![
            object(0, b"Linewright"),
            object(PRODUCT_CODE, PRODUCT),
            object(2, env!("CARGO_PKG_VERSION").as_bytes()),
        ],
    })
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
        _ => return None,
    })
}

/// Whether the devices at this address are simulated, by their identification. Writes nothing.
///
/// # Errors
/// When there is no answer.
pub async fn is_simulated(at: (&str, u8)) -> Result<bool, String> {
    let answer = request(at, Request::ReadDeviceIdentification(ReadCode::Basic, 0)).await?;
    let Ok(Response::ReadDeviceIdentification(identity)) = answer else { return Ok(false) };
    let is_product = |object: &DeviceIdObject| object.id == PRODUCT_CODE && *object.value == *PRODUCT;
    Ok(identity.device_id_objects.iter().any(is_product))
}

/// Makes the simulated Modbus device `device` at this address and unit fail: writes a number to one of the objects that a simulated
/// CANopen device has for it. To be asked first: [`is_simulated`].
///
/// # Errors
/// Why it does not: there is none, or it has no such fault.
pub async fn fail_device(at: (&str, u8), device: &str, object: (u16, u8), value: u32) -> Result<(), String> {
    let head = [&object.0.to_be_bytes()[..], &[object.1], &value.to_be_bytes()].concat();
    let data = [&head, device.as_bytes()].concat();
    match request(at, Request::Custom(FAULT_FUNCTION, data.into())).await? {
        Ok(_) => Ok(()),
        Err(ExceptionCode::IllegalDataValue) => {
            Err(format!("{device} at {} has no such fault; a device in Modbus can be silent, reboot or no-boot", at.0))
        }
        Err(refused) => Err(format!("{device} at {} refuses it: {refused}", at.0)),
    }
}

/// The answer to a request on a connection of its own.
async fn request((address, unit): (&str, u8), request: Request<'_>) -> Result<Result<Response, ExceptionCode>, String> {
    let gone = |error: &dyn std::fmt::Display| {
        format!("no simulated device answers at {address}: {error}; is the simulated plant running?")
    };
    let answered = async {
        let stream = TcpStream::connect(address).await.map_err(|error| gone(&error))?;
        let mut context = tcp::attach_slave(stream, Slave(unit));
        context.call(request).await.map_err(|error| gone(&error))
    };
    let answer = tokio::time::timeout(ANSWER, answered).await;
    answer.unwrap_or_else(|_| Err(gone(&format!("nothing within {} s", ANSWER.as_secs()))))
}

fn response_to(request: &Request<'_>, response: ModbusResponse) -> Option<Response> {
    Some(match (request, response) {
        (Request::ReadCoils(..), ModbusResponse::Bits(bits)) => Response::ReadCoils(bits),
        (Request::ReadDiscreteInputs(..), ModbusResponse::Bits(bits)) => Response::ReadDiscreteInputs(bits),
        (Request::ReadHoldingRegisters(..), ModbusResponse::Words(words)) => Response::ReadHoldingRegisters(words),
        (Request::ReadInputRegisters(..), ModbusResponse::Words(words)) => Response::ReadInputRegisters(words),
        (Request::WriteSingleCoil(at, on), ModbusResponse::Written) => Response::WriteSingleCoil(*at, *on),
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
