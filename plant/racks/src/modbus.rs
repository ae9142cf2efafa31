//! The Modbus TCP servers of a rack: each address of its devices is listened at, and every request answered by the rack.

use std::collections::BTreeMap;
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::time::Duration;

use super::PlantError;
use super::texts::{ModbusFaultError, PlantNews};
use linewright_line::{Device, Line, Table};
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
/// data: index (2 bytes) and subindex of the object, a number (4 bytes), and the device's name; of the answer: the number of injected
/// faults that hold then (2 bytes). To a real device it may mean
/// anything: it is sent only to an address where devices are simulated.
const FAULT_FUNCTION: u8 = 65;
/// Product code in the identification (§6.21, function 43) of each simulated device.
const PRODUCT: &[u8] = b"Linewright simulated device";
/// The number of the product code there.
const PRODUCT_CODE: u8 = 1;
/// The number of the run there, one of those that the specification leaves to makers.
const RUN: u8 = 0x80;
/// As much of a run's name is given: all of an answer has 253 bytes.
const RUN_BYTES_MAX: usize = 160;
/// How long its answer is waited for.
const ANSWER: Duration = Duration::from_secs(2);
/// Requests that wait for the rack.
const QUEUE: usize = 16;

/// What comes to a rack's servers. The answer is an exception's code where it is refused, `None` for none.
pub enum Asked {
    /// A request to the device at this address and unit.
    Request { at: (String, u8), request: ModbusRequest, reply: oneshot::Sender<Option<Result<ModbusResponse, u8>>> },
    /// A fault for the device of this name: an object of a simulated CANopen device, and a number. The answer is the number of
    /// injected faults that hold then.
    Fault { at: (String, u8), device: String, fault: FaultWrite, reply: oneshot::Sender<Option<Result<u16, u8>>> },
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
    /// Listens at these addresses, for a plant of this run.
    ///
    /// # Errors
    /// At which it cannot be listened, and why.
    pub fn open(addresses: &[String], run: Option<&str>) -> Result<Self, (String, io::Error)> {
        let (to, asked) = mpsc::channel(QUEUE);
        let mut tasks = Vec::new();
        for address in addresses {
            let listener = listen(address).map_err(|error| (address.clone(), error))?;
            tasks.push(tokio::spawn(serve(Server::new(listener), address.clone(), cut(run), to.clone())));
        }
        Ok(Servers { asked, _to: to, tasks })
    }

    /// Waits for the next request. Cancel safe.
    pub async fn next(&mut self) -> Option<Asked> {
        self.asked.recv().await
    }
}

/// The name of a run, as much of it as an identification has; nothing of none.
fn cut(run: Option<&str>) -> String {
    let run = run.unwrap_or_default();
    run[..run.floor_char_boundary(RUN_BYTES_MAX)].to_owned()
}

fn listen(address: &str) -> io::Result<TcpListener> {
    let listener = std::net::TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    TcpListener::from_std(listener)
}

async fn serve(server: Server, address: String, run: String, to: mpsc::Sender<Asked>) {
    let connected = |stream: TcpStream, peer| {
        let device = ServedDevice { address: address.clone(), run: run.clone(), to: to.clone() };
        let is_open = stream.set_nodelay(true);
        std::future::ready(is_open.and_then(|()| accept_tcp_connection(stream, peer, |_| Ok(Some(device.clone())))))
    };
    let failed = |error| tracing::debug!("a Modbus connection has ended: {error}");
    if let Err(error) = server.serve(&connected, failed).await {
        tracing::warn!("{}", PlantNews::ServerEnded { address: &address, why: error.to_string() });
    }
}

/// A connection to the devices at an address.
#[derive(Clone)]
struct ServedDevice {
    address: String,
    run: String,
    to: mpsc::Sender<Asked>,
}

impl Service for ServedDevice {
    type Request = SlaveRequest<'static>;
    type Response = Option<Response>;
    type Exception = ExceptionCode;
    type Future = Pin<Box<dyn Future<Output = Result<Option<Response>, ExceptionCode>> + Send>>;

    fn call(&self, SlaveRequest { slave, request }: SlaveRequest<'static>) -> Self::Future {
        let (to, at, run) = (self.to.clone(), (self.address.clone(), slave), self.run.clone());
        Box::pin(async move {
            match &request {
                Request::ReadDeviceIdentification(code, _) => return Ok(Some(identification(*code, &run))),
                Request::Custom(FAULT_FUNCTION, data) => {
                    let (device, fault) = fault_of(data).ok_or(ExceptionCode::IllegalDataValue)?;
                    let (reply, answer) = oneshot::channel();
                    let done = answered(&to, Asked::Fault { at, device, fault, reply }, answer).await?;
                    let response = |faults: u16| Response::Custom(FAULT_FUNCTION, faults.to_be_bytes().to_vec().into());
                    return Ok(done.map(response));
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
fn identification(read_code: ReadCode, run: &str) -> Response {
    let object = |id, value: &[u8]| DeviceIdObject { id, value: value.to_vec().into() };
    let mut objects =
        vec![object(0, b"Linewright"), object(PRODUCT_CODE, PRODUCT), object(2, env!("CARGO_PKG_VERSION").as_bytes())];
    if !run.is_empty() && matches!(read_code, ReadCode::Extended) {
        objects.push(object(RUN, run.as_bytes()));
    }
    Response::ReadDeviceIdentification(ReadDeviceIdentificationResponse {
        read_code,
        conformity_level: ConformityLevel::BasicIdentificationStreamOnly,
        more_follows: false,
        next_object_id: 0,
        device_id_objects: objects,
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

/// What answers at an address, by its identification.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Served {
    /// Simulated devices of this run of a line; of none where the plant was started by itself.
    Simulated { run: Option<String> },
    /// A server that is no simulated device.
    Other,
}

impl Served {
    /// The run that these devices belong to, if it is not `run`. Those of a plant that was started by itself are for all.
    pub fn other_run(&self, run: &str) -> Option<&str> {
        match self {
            Served::Simulated { run: Some(theirs) } if *theirs != cut(Some(run)) => Some(theirs),
            Served::Simulated { .. } | Served::Other => None,
        }
    }
}

/// What answers at this address. Writes nothing.
///
/// # Errors
/// When there is no answer.
pub async fn served_at(at: (&str, u8)) -> Result<Served, String> {
    let answer = request(at, Request::ReadDeviceIdentification(ReadCode::Extended, 0)).await?;
    let Ok(Response::ReadDeviceIdentification(identity)) = answer else { return Ok(Served::Other) };
    let value = |id| identity.device_id_objects.iter().find(|object| object.id == id).map(|object| &*object.value);
    if value(PRODUCT_CODE) != Some(PRODUCT) {
        return Ok(Served::Other);
    }
    Ok(Served::Simulated { run: value(RUN).map(|run| String::from_utf8_lossy(run).into_owned()) })
}

/// The addresses of the line's Modbus devices, each with the unit of one of them.
fn addresses(line: &Line) -> BTreeMap<&str, u8> {
    line.devices.iter().filter_map(Device::modbus).map(|modbus| (modbus.address.as_str(), modbus.unit)).collect()
}

/// Whether the Modbus devices of a line can be served: nothing else listens at their addresses.
///
/// # Errors
/// At which of them not, and why.
pub async fn can_be_served(line: &Line) -> Result<(), PlantError> {
    for (address, unit) in addresses(line) {
        if let Err(error) = std::net::TcpListener::bind(address) {
            let by = match error.kind() {
                io::ErrorKind::AddrInUse => served_at((address, unit)).await.ok(),
                _ => None,
            };
            return Err(cannot_serve(address, error, by));
        }
    }
    Ok(())
}

/// Whether each Modbus device of a line is served by the plant of this run.
pub async fn are_served(line: &Line, run: &str) -> bool {
    for at in addresses(line) {
        match served_at(at).await {
            Ok(Served::Simulated { run: Some(theirs) }) if theirs == cut(Some(run)) => {}
            _ => return false,
        }
    }
    true
}

/// The error, with what serves there already.
pub(crate) fn cannot_serve(address: &str, error: io::Error, by: Option<Served>) -> PlantError {
    let address = address.to_owned();
    if error.kind() != io::ErrorKind::AddrInUse {
        return PlantError::Modbus { address, error };
    }
    PlantError::ModbusTaken { address, by }
}

/// Makes the simulated Modbus device `device` at this address and unit fail: writes a number to one of the objects that a simulated
/// CANopen device has for it, and gives the number of injected faults that hold then. 5F07h changes nothing. To be asked first:
/// [`served_at`].
///
/// # Errors
/// Why it does not: there is none, or it has no such fault.
pub async fn fail_device(at: (&str, u8), device: &str, object: (u16, u8), value: u32) -> Result<u16, String> {
    let head = [&object.0.to_be_bytes()[..], &[object.1], &value.to_be_bytes()].concat();
    let data = [&head, device.as_bytes()].concat();
    match request(at, Request::Custom(FAULT_FUNCTION, data.into())).await? {
        Ok(Response::Custom(FAULT_FUNCTION, faults)) if let Ok(faults) = <[u8; 2]>::try_from(&faults[..]) => {
            Ok(u16::from_be_bytes(faults))
        }
        Ok(_) => {
            let why = "its answer has no number of faults".to_owned();
            Err(ModbusFaultError::Refused { device, address: at.0, why }.to_string())
        }
        Err(ExceptionCode::IllegalDataValue) => {
            Err(ModbusFaultError::NoSuchFault { device, address: at.0 }.to_string())
        }
        Err(refused) => Err(ModbusFaultError::Refused { device, address: at.0, why: refused.to_string() }.to_string()),
    }
}

/// The answer to a request on a connection of its own.
async fn request((address, unit): (&str, u8), request: Request<'_>) -> Result<Result<Response, ExceptionCode>, String> {
    let gone =
        |error: &dyn std::fmt::Display| ModbusFaultError::Unreachable { address, why: error.to_string() }.to_string();
    let answered = async {
        let stream = TcpStream::connect(address).await.map_err(|error| gone(&error))?;
        let mut context = tcp::attach_slave(stream, Slave(unit));
        context.call(request).await.map_err(|error| gone(&error))
    };
    let answer = tokio::time::timeout(ANSWER, answered).await;
    answer.unwrap_or_else(|_| Err(ModbusFaultError::Unanswered { address, within: ANSWER }.to_string()))
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
