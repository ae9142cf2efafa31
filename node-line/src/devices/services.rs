//! The services: requests to a device, and their answers.
//!
//! The types of `ros2_canopen` have room for "no" and for a number, not for words. So for a failed read the number is
//! the abort code; the words are in the log and in the device's diagnostics.

use linewright_fieldbus_seam::{Answer, BusReply as Read, BusRequest, BusTarget, Joined, ObjectAddress, abort};
use linewright_msgs::{
    CORead, COReadID, COWrite, COWriteID, CoReadIdRequest, CoReadIdResponse, CoReadRequest, CoReadResponse,
    CoWriteIdRequest, CoWriteIdResponse, CoWriteRequest, CoWriteResponse, Trigger, TriggerResponse,
};
use linewright_node_shell::{Forward, RosNode, ServiceReply, TopicError, serve};
use tokio::sync::mpsc;

use super::Devices;
use super::numbers::{bytes_of, is_signed, low_bytes, number};

/// Request to a service.
#[derive(Debug)]
pub struct DeviceServiceRequest {
    target: BusTarget,
    request: BusRequest,
    answerer: Answerer,
}

/// Destination of the answer.
#[derive(Debug)]
enum Answerer {
    Trigger(ServiceReply<Trigger>),
    Read(ServiceReply<CORead>),
    Write(ServiceReply<COWrite>),
    ReadId(ServiceReply<COReadID>),
    WriteId(ServiceReply<COWriteID>),
}

/// A request that the bus has not answered yet.
pub struct PendingTransfer {
    number: u64,
    target: BusTarget,
    answerer: Answerer,
}

/// The services of a bus, by node id: `~/sdo_read`, `~/sdo_write`.
pub fn open_bus(node: &mut RosNode, to: &mpsc::Sender<DeviceServiceRequest>) -> Result<Vec<Forward>, TopicError> {
    let read = serve(node.service::<COReadID>("~/sdo_read")?, to.clone(), |asked: CoReadIdRequest, reply| {
        let request = BusRequest::Read(ObjectAddress { index: asked.index, sub: asked.subindex });
        DeviceServiceRequest { target: BusTarget::Node(asked.nodeid), request, answerer: Answerer::ReadId(reply) }
    });
    let write = serve(node.service::<COWriteID>("~/sdo_write")?, to.clone(), |asked: CoWriteIdRequest, reply| {
        let bytes = bytes_of(asked.canopen_datatype);
        // A negative number of a short type comes with its sign in the bytes above it.
        let value = if is_signed(asked.canopen_datatype) { low_bytes(asked.data, bytes) } else { asked.data };
        let object = ObjectAddress { index: asked.index, sub: asked.subindex };
        let target = BusTarget::Node(asked.nodeid.cast_unsigned());
        DeviceServiceRequest {
            target,
            request: BusRequest::Write { object, value, bytes },
            answerer: Answerer::WriteId(reply),
        }
    });
    Ok(vec![read, write])
}

/// The services of one device: `<device>/nmt_reset_node`, `nmt_start_node`, `sdo_read`, `sdo_write`.
pub fn open_device(
    node: &mut RosNode,
    name: &str,
    target: &BusTarget,
    to: &mpsc::Sender<DeviceServiceRequest>,
) -> Result<Vec<Forward>, TopicError> {
    let asked = {
        let target = target.clone();
        move |request, answerer| DeviceServiceRequest { target: target.clone(), request, answerer }
    };
    let reset = node.service::<Trigger>(&format!("{name}/nmt_reset_node"))?;
    let start = node.service::<Trigger>(&format!("{name}/nmt_start_node"))?;
    let read = node.service::<CORead>(&format!("{name}/sdo_read"))?;
    let write = node.service::<COWrite>(&format!("{name}/sdo_write"))?;
    let [of_reset, of_start, of_read, of_write] = [asked.clone(), asked.clone(), asked.clone(), asked];
    Ok(vec![
        serve(reset, to.clone(), move |_, reply| of_reset(BusRequest::Reset, Answerer::Trigger(reply))),
        serve(start, to.clone(), move |_, reply| of_start(BusRequest::Start, Answerer::Trigger(reply))),
        serve(read, to.clone(), move |request: CoReadRequest, reply| {
            let object = ObjectAddress { index: request.index, sub: request.subindex };
            of_read(BusRequest::Read(object), Answerer::Read(reply))
        }),
        serve(write, to.clone(), move |request: CoWriteRequest, reply| {
            let object = ObjectAddress { index: request.index, sub: request.subindex };
            of_write(BusRequest::Write { object, value: request.data, bytes: None }, Answerer::Write(reply))
        }),
    ])
}

impl Answerer {
    fn send(self, answer: &Answer) {
        let success = answer.is_ok();
        // Objects longer than a number (a name, say) are not read by these services.
        let value = match answer {
            Ok(Read { value, .. }) => number(value).ok_or(abort::TOO_LONG),
            Err(refusal) => Err(refusal.code),
        };
        let (read, data) = match value {
            Ok(data) => (true, data),
            Err(code) => (false, code),
        };
        match self {
            Answerer::Read(reply) => reply.send(CoReadResponse { success: read, data }),
            Answerer::ReadId(reply) => reply.send(CoReadIdResponse { success: read, data }),
            Answerer::Write(reply) => reply.send(CoWriteResponse { success }),
            Answerer::WriteId(reply) => reply.send(CoWriteIdResponse { success }),
            Answerer::Trigger(reply) => {
                let message = match answer {
                    Ok(Read { text, .. }) => text.clone(),
                    Err(refusal) => refusal.text.clone(),
                };
                reply.send(TriggerResponse { success, message });
            }
        }
    }
}

impl Devices {
    /// Passes a request on to the buses.
    pub fn ask(&mut self, asked: DeviceServiceRequest, buses: &mut Joined) {
        let DeviceServiceRequest { target, request, answerer } = asked;
        tracing::info!("asked: {target}, {request}");
        let number = buses.ask(&target, request);
        self.pending.push(PendingTransfer { number, target, answerer });
        self.answer(buses);
    }

    /// Sends the answers the buses have.
    pub(super) fn answer(&mut self, buses: &mut Joined) {
        for (number, answer) in buses.take_answers() {
            let Some(at) = self.pending.iter().position(|pending| pending.number == number) else { continue };
            let PendingTransfer { target, answerer, .. } = self.pending.swap_remove(at);
            let failed = answer.as_ref().err().map_or(String::new(), |refusal| refusal.text.clone());
            if !failed.is_empty() {
                tracing::warn!("{failed}");
            }
            // The answer has the reason why it is not started.
            let is_told = !matches!(answerer, Answerer::Trigger(_));
            if let Some(told) = self.told.iter_mut().find(|told| told.target == target && is_told) {
                told.failed = failed;
            }
            answerer.send(&answer);
        }
    }
}
