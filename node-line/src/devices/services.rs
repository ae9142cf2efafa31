//! The services: what is asked of a device, and what is answered.
//!
//! The types of `ros2_canopen` have room for "no" and for a number, not for words. So where something was to be read, the
//! number is the abort code that says why it was not; the words are in the log and in the device's diagnostics.

use linewright_canopen::manager::Ask;
use linewright_canopen::sdo::{Abort, ObjectId};
use linewright_canopen::{Answer, AskError};
use linewright_fieldbus::Driver;
use linewright_msgs::{
    CORead, COReadID, COWrite, COWriteID, CoReadIdRequest, CoReadIdResponse, CoReadRequest, CoReadResponse,
    CoWriteIdRequest, CoWriteIdResponse, CoWriteRequest, CoWriteResponse, Trigger, TriggerResponse,
};
use linewright_node_shell::{Forward, Node, Reply, TopicError, serve};
use tokio::sync::mpsc;

use super::{Devices, node_id};

/// Something a service was asked.
#[derive(Debug)]
pub struct Asked {
    node: u8,
    what: What,
}

#[derive(Debug)]
enum What {
    Reset(Reply<Trigger>),
    Start(Reply<Trigger>),
    Transfer(Ask, Answerer),
}

/// Where the answer to a transfer goes.
#[derive(Debug)]
enum Answerer {
    Read(Reply<CORead>),
    Write(Reply<COWrite>),
    ReadId(Reply<COReadID>),
    WriteId(Reply<COWriteID>),
}

/// A transfer that the manager has not answered yet.
pub struct Pending {
    number: u64,
    node: u8,
    ask: Ask,
    answerer: Answerer,
}

/// The services of a bus, by node id: `~/sdo_read`, `~/sdo_write`.
pub fn open_bus(node: &mut Node, to: &mpsc::Sender<Asked>) -> Result<Vec<Forward>, TopicError> {
    let read = serve(node.service::<COReadID>("~/sdo_read")?, to.clone(), |asked: CoReadIdRequest, reply| {
        let ask = Ask::Read(ObjectId::new(asked.index, asked.subindex));
        Asked { node: asked.nodeid, what: What::Transfer(ask, Answerer::ReadId(reply)) }
    });
    let write = serve(node.service::<COWriteID>("~/sdo_write")?, to.clone(), |asked: CoWriteIdRequest, reply| {
        let bytes = bytes_of(asked.canopen_datatype);
        // A negative number of a short type comes with its sign in the bytes above it.
        let value = if is_signed(asked.canopen_datatype) { low_bytes(asked.data, bytes) } else { asked.data };
        let ask = Ask::Write { object: ObjectId::new(asked.index, asked.subindex), value, bytes };
        Asked { node: asked.nodeid.cast_unsigned(), what: What::Transfer(ask, Answerer::WriteId(reply)) }
    });
    Ok(vec![read, write])
}

/// The services of one device: `<device>/nmt_reset_node`, `nmt_start_node`, `sdo_read`, `sdo_write`.
pub fn open_device(node: &mut Node, name: &str, id: u8, to: &mpsc::Sender<Asked>) -> Result<Vec<Forward>, TopicError> {
    let asked = move |what| Asked { node: id, what };
    let reset = node.service::<Trigger>(&format!("{name}/nmt_reset_node"))?;
    let start = node.service::<Trigger>(&format!("{name}/nmt_start_node"))?;
    let read = node.service::<CORead>(&format!("{name}/sdo_read"))?;
    let write = node.service::<COWrite>(&format!("{name}/sdo_write"))?;
    Ok(vec![
        serve(reset, to.clone(), move |_, reply| asked(What::Reset(reply))),
        serve(start, to.clone(), move |_, reply| asked(What::Start(reply))),
        serve(read, to.clone(), move |request: CoReadRequest, reply| {
            let ask = Ask::Read(ObjectId::new(request.index, request.subindex));
            asked(What::Transfer(ask, Answerer::Read(reply)))
        }),
        serve(write, to.clone(), move |request: CoWriteRequest, reply| {
            let object = ObjectId::new(request.index, request.subindex);
            asked(What::Transfer(Ask::Write { object, value: request.data, bytes: None }, Answerer::Write(reply)))
        }),
    ])
}

/// How long an object of this type (CiA 301 table 44) is; `None` for one the service does not know.
fn bytes_of(datatype: u8) -> Option<usize> {
    match datatype {
        CoReadIdRequest::CANOPEN_DATATYPE_INT8 | CoReadIdRequest::CANOPEN_DATATYPE_UINT8 => Some(1),
        CoReadIdRequest::CANOPEN_DATATYPE_INT16 | CoReadIdRequest::CANOPEN_DATATYPE_UINT16 => Some(2),
        CoReadIdRequest::CANOPEN_DATATYPE_INT32 | CoReadIdRequest::CANOPEN_DATATYPE_UINT32 => Some(4),
        _ => None,
    }
}

fn is_signed(datatype: u8) -> bool {
    (CoReadIdRequest::CANOPEN_DATATYPE_INT8..=CoReadIdRequest::CANOPEN_DATATYPE_INT32).contains(&datatype)
}

fn low_bytes(value: u32, bytes: Option<usize>) -> u32 {
    match bytes {
        Some(bytes @ 1..=3) if value >> (8 * bytes - 1) == u32::MAX >> (8 * bytes - 1) => {
            value & ((1 << (8 * bytes)) - 1)
        }
        _ => value,
    }
}

/// A value that has been read, as a number.
fn number(bytes: &[u8]) -> Option<u32> {
    let mut all = [0; 4];
    all.get_mut(..bytes.len())?.copy_from_slice(bytes);
    Some(u32::from_le_bytes(all))
}

impl Answerer {
    fn send(self, answer: &Answer) {
        let success = answer.is_ok();
        // What is longer than a number (a name, say) is not read by these services.
        let value = match answer {
            Ok(bytes) => number(bytes).ok_or(Abort::TOO_LONG),
            Err(error) => Err(error.abort()),
        };
        let (read, data) = match value {
            Ok(data) => (true, data),
            Err(Abort(code)) => (false, code),
        };
        match self {
            Answerer::Read(reply) => reply.send(CoReadResponse { success: read, data }),
            Answerer::ReadId(reply) => reply.send(CoReadIdResponse { success: read, data }),
            Answerer::Write(reply) => reply.send(CoWriteResponse { success }),
            Answerer::WriteId(reply) => reply.send(CoWriteIdResponse { success }),
        }
    }
}

impl Devices {
    /// Passes a request on to the manager.
    pub fn ask(&mut self, asked: Asked, driver: &mut Driver) {
        let Asked { node, what } = asked;
        match what {
            What::Transfer(ask, answerer) => {
                tracing::info!("asked: {}", in_words(node, &ask));
                let number = driver.ask(node, ask);
                self.pending.push(Pending { number, node, ask, answerer });
            }
            What::Reset(reply) => {
                tracing::info!("asked to reset node {node:02X}h");
                if let Some(node) = node_id(node) {
                    driver.reset_node(node);
                }
                reply.send(TriggerResponse { success: true, message: "ordered to reset".into() });
            }
            What::Start(reply) => {
                tracing::info!("asked to start node {node:02X}h");
                let said = node_id(node).map_or(Err("no node id".to_owned()), |node| driver.start_node(node));
                let (success, message) = said.map_or_else(|why| (false, why), |how| (true, how));
                reply.send(TriggerResponse { success, message });
            }
        }
        self.answer(driver);
    }

    /// Sends the answers the manager has.
    pub(super) fn answer(&mut self, driver: &mut Driver) {
        for (number, answer) in driver.take_answers() {
            let Some(at) = self.pending.iter().position(|pending| pending.number == number) else { continue };
            let Pending { node, ask, answerer, .. } = self.pending.swap_remove(at);
            let failed = answer.as_ref().err().map_or(String::new(), |error| why(node, &ask, error));
            if !failed.is_empty() {
                tracing::warn!("{failed}");
            }
            if let Some(told) = self.told(node) {
                told.failed = failed;
            }
            answerer.send(&answer);
        }
    }
}

fn in_words(node: u8, ask: &Ask) -> String {
    match ask {
        Ask::Read(object) => format!("node {node:02X}h, read object {object}"),
        Ask::Write { object, value, .. } => format!("node {node:02X}h, write {value} ({value:X}h) to object {object}"),
    }
}

fn why(node: u8, ask: &Ask, error: &AskError) -> String {
    format!("{}: {error}", in_words(node, ask))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_long_as_their_type() {
        assert_eq!(number(&[0x34, 0x12]), Some(0x1234));
        assert_eq!(number(&[]), Some(0));
        assert_eq!(number(&[0; 5]), None);
        assert_eq!((bytes_of(2), bytes_of(6), bytes_of(7), bytes_of(8)), (Some(1), Some(2), Some(4), None));
        // −1 as one byte, whether its sign was extended or not; 300 stays too large for one.
        assert_eq!(low_bytes(u32::MAX, Some(1)), 0xFF);
        assert_eq!(low_bytes(0xFF, Some(1)), 0xFF);
        assert_eq!(low_bytes(0xFFFF_8000, Some(2)), 0x8000);
        assert_eq!(low_bytes(0xFFFF_0000, Some(2)), 0xFFFF_0000, "not a negative number of two bytes");
        assert_eq!(low_bytes(300, Some(1)), 300);
        assert_eq!(low_bytes(u32::MAX, Some(4)), u32::MAX);
    }
}
