//! Service server.
//!
//! ROS 2 has two ways of relating an answer to its request. Fast DDS does it beside the data (the client library's
//! *enhanced* mapping), Cyclone DDS in sixteen bytes before them. A server of the client library supports one of them,
//! and the clients of a line are not known in advance. So requests are taken as the bytes they are, and make sense in
//! one of the two ways: as all of them, or as all behind the first sixteen. The answer goes the way the request came.
//!
//! A client can send a request before this side has discovered where its answers are to go: the two ways between two
//! nodes are discovered one by one, and an answer sent too early is lost for good. So the first answer to a client is
//! held for a moment, as other implementations do.
//!
//! Each request gets one answer or none; nothing here waits. Bytes are read as little endian, which is what every host
//! that ROS 2 supports sends.

use std::collections::VecDeque;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use linewright_msgs::{RosMessage, RosService};
use ros2_client::{Gid, ReadError, Server, service::RmwRequestId};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use tokio::sync::mpsc;

use crate::bytes::{Bytes, exactly};
use crate::subscription::{Forward, participant_of};

/// Bytes of Cyclone's header: half of the client's identity, and the number of the request.
const HEADER: usize = 16;
/// Most bytes of a request that are looked at; more makes no sense.
const REQUEST_MAX: usize = 64 * 1024;

/// Time for which the first answer to a client is held (that of rmw_fastrtps).
pub(crate) const HOLD: Duration = Duration::from_millis(100);
/// Clients remembered for each service. For a further one the answer is held once more.
const CLIENTS: usize = 16;

/// The clients that have been answered, the newest first.
pub(crate) struct KnownClients(VecDeque<Gid>);

impl KnownClients {
    pub fn new() -> Self {
        KnownClients(VecDeque::with_capacity(CLIENTS))
    }

    /// Whether a client is new; true once for each.
    pub fn meets(&mut self, client: Gid) -> bool {
        let is_new = !self.0.contains(&client);
        if is_new {
            self.0.truncate(CLIENTS - 1);
            self.0.push_front(client);
        }
        is_new
    }
}

/// A request as it came.
pub(crate) type RawRequest = Bytes<REQUEST_MAX>;

/// The header of Cyclone DDS if there is one, and the request.
fn read<T: RosMessage>(raw: &RawRequest) -> Option<(Option<[u8; HEADER]>, T)> {
    if let Some(message) = exactly(&raw.0) {
        return Some((None, message));
    }
    let (header, body) = raw.0.split_first_chunk::<HEADER>()?;
    Some((Some(*header), exactly(body)?))
}

/// An answer, with the header of its request.
pub(crate) struct RawResponse<T> {
    header: Option<[u8; HEADER]>,
    body: T,
}

impl<T: Serialize> Serialize for RawResponse<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.header {
            Some(header) => (header, &self.body).serialize(serializer),
            None => self.body.serialize(serializer),
        }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for RawResponse<T> {
    /// Only sent; the client library requires both.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(|body| RawResponse { header: None, body })
    }
}

impl<T: RosMessage> ros2_client::Message for RawResponse<T> {}

pub(crate) type RawServer<S> = Server<RawRequest, RawResponse<<S as RosService>::Response>>;

/// A service that is offered.
pub struct Service<S: RosService> {
    pub(crate) inner: Arc<RawServer<S>>,
    pub(crate) name: String,
}

/// Answers one request, once.
pub struct ServiceReply<S: RosService> {
    server: Arc<RawServer<S>>,
    to: RmwRequestId,
    header: Option<[u8; HEADER]>,
    held: bool,
    service: PhantomData<S>,
}

impl<S: RosService> fmt::Debug for ServiceReply<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Reply to {:?}", self.to)
    }
}

impl<S: RosService> ServiceReply<S> {
    /// Identity of the client: one per client and start of its process.
    pub fn client(&self) -> [u8; 16] {
        self.to.writer_gid.to_bytes16()
    }

    /// The participant that the client belongs to, as [`MessageSource::participant`](crate::MessageSource::participant).
    pub fn participant(&self) -> [u8; 12] {
        participant_of(&self.client())
    }

    /// Sends the answer. Never waits; a client that has gone meanwhile gets none.
    pub fn send(self, response: S::Response) {
        let ServiceReply { server, to, header, held, .. } = self;
        let send = move || {
            if let Err(error) = server.send_response(to, RawResponse { header, body: response }) {
                /// Of all services of the process: requests must not fill a disk.
                static UNSENT: AtomicU64 = AtomicU64::new(0);
                let unsent = UNSENT.fetch_add(1, Ordering::Relaxed) + 1;
                if unsent.is_power_of_two() {
                    tracing::warn!(unsent, "{}/{}: answer not sent: {error}", S::PACKAGE, S::NAME);
                }
            }
        };
        match tokio::runtime::Handle::try_current() {
            Ok(runtime) if held => {
                runtime.spawn(async move {
                    tokio::time::sleep(HOLD).await;
                    send();
                });
            }
            Ok(_) | Err(_) => send(),
        }
    }
}

/// Merges a service's requests into `to`, as [`forward`](crate::forward) does with messages. Must be called inside a
/// tokio runtime.
pub fn serve<S, U>(
    service: Service<S>,
    to: mpsc::Sender<U>,
    mut map: impl FnMut(S::Request, ServiceReply<S>) -> U + Send + 'static,
) -> Forward
where
    S: RosService,
    U: Send + 'static,
{
    let Service { inner: server, name } = service;
    Forward::spawn(async move {
        let mut rejected = 0u64;
        let mut known = KnownClients::new();
        loop {
            let received = tokio::select! {
                received = server.async_receive_request() => received,
                () = to.closed() => return,
            };
            let asked = match received {
                Ok((id, raw)) => read::<S::Request>(&raw).map(|asked| (id, asked)),
                Err(ReadError::Deserialization { .. } | ReadError::Malformed) => None,
                Err(error) => {
                    tracing::error!("{name}: the middleware failed: {error}");
                    return;
                }
            };
            match asked {
                Some((id, (header, request))) => {
                    let held = known.meets(id.writer_gid);
                    let reply = ServiceReply { server: server.clone(), to: id, header, held, service: PhantomData };
                    if to.send(map(request, reply)).await.is_err() {
                        return;
                    }
                }
                None => {
                    rejected += 1;
                    if rejected.is_power_of_two() {
                        tracing::warn!(service = name, rejected, "ignored a request that does not decode");
                    }
                }
            }
            // As with messages: a flood of rubbish must not keep the other tasks waiting.
            tokio::task::yield_now().await;
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_msgs::{
        CoReadRequest, GetParametersRequest, ListParametersRequest, Parameter, ParameterValue, ProductionRequest,
        SetParametersRequest, SubmitOrdersRequest, TriggerRequest, WhyNotRequest,
    };
    use proptest::prelude::*;

    fn both_ways<T: RosMessage + PartialEq + fmt::Debug>(asked: &T, header: [u8; HEADER], padding: usize) {
        let bytes = cdr_encoding::to_vec::<T, byteorder::LittleEndian>(asked).expect("encodes");
        let padded = [&bytes[..], &vec![0; padding]].concat();
        let found = read::<T>(&Bytes(padded.clone())).expect("it makes sense");
        assert_eq!((found.0, &found.1), (None, asked));
        let found = read::<T>(&Bytes([&header[..], &padded].concat())).expect("it makes sense with a header");
        assert_eq!((found.0, &found.1), (Some(header), asked));
        assert!(read::<T>(&Bytes([&header[..], &padded, &header].concat())).is_none(), "and not with more behind it");
    }

    proptest! {
        /// Half of a client's identity, and the number of the request, which is small.
        #[test]
        fn a_request_is_read_in_the_way_it_came(
            client: u64,
            number in 0..1_000_000_u64,
            padding in 0..4_usize,
            names in prop::collection::vec("[a-z ]{0,40}", 0..4),
        ) {
            // Identities are of participants of ours or of others: drawn, or made of addresses; not small numbers.
            let header = [(client | 1 << 40).to_le_bytes(), number.to_le_bytes()].concat();
            let header = <[u8; HEADER]>::try_from(header).expect("sixteen");
            both_ways(&TriggerRequest::default(), header, padding.min(2));
            both_ways(&CoReadRequest { index: 0x1018, subindex: 1 }, header, padding);
            let of = |name: &String| ProductionRequest { name: name.clone(), after: names.clone(), ..Default::default() };
            both_ways(&SubmitOrdersRequest { requests: names.iter().map(of).collect() }, header, padding);
            both_ways(&GetParametersRequest { names: names.clone() }, header, padding);
            both_ways(&ListParametersRequest { prefixes: names.clone(), depth: number }, header, padding);
            let value = ParameterValue { r#type: 4, string_value: "debug".into(), ..Default::default() };
            let one = |name: &String| Parameter { name: name.clone(), value: value.clone() };
            both_ways(&SetParametersRequest { parameters: names.iter().map(one).collect() }, header, padding);
            for about in &names {
                both_ways(&WhyNotRequest { about: about.clone() }, header, padding);
            }
        }
    }
}
