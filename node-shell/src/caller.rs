//! Service client, for tools and tests.

use std::time::Duration;

use linewright_msgs::{Invalid, RosMessage, RosService};
use ros2_client::{Client, ServiceMapping};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// How an answer is related to its request; the server's middleware decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// Beside the data, as Fast DDS does.
    Enhanced,
    /// In sixteen bytes before the data, as Cyclone DDS does.
    Cyclone,
}

impl From<Mapping> for ServiceMapping {
    fn from(mapping: Mapping) -> Self {
        match mapping {
            Mapping::Enhanced => ServiceMapping::Enhanced,
            Mapping::Cyclone => ServiceMapping::Cyclone,
        }
    }
}

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum CallError {
    /// No answer came.
    #[error("{service}: no answer within {} ms", within.as_millis())]
    NoAnswer {
        service: String,
        /// Time waited.
        within: Duration,
    },
    /// The answer is invalid.
    #[error("{service}: {invalid}")]
    Invalid {
        service: String,
        /// Field and limit that is violated.
        invalid: Invalid,
    },
    /// The middleware has failed.
    #[error("{service}: {reason}")]
    Middleware {
        service: String,
        /// Its words.
        reason: String,
    },
}

/// A message in the form that the client library needs.
#[derive(Clone, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct WireMessage<T>(pub(crate) T);

impl<T: RosMessage> ros2_client::Message for WireMessage<T> {}

pub(crate) type RawServiceClient<S> =
    Client<WireMessage<<S as RosService>::Request>, WireMessage<<S as RosService>::Response>>;

/// Client of one service.
pub struct Caller<S: RosService> {
    pub(crate) inner: RawServiceClient<S>,
    pub(crate) name: String,
}

impl<S: RosService> Caller<S> {
    /// Sends a request, and waits for the answer. A request sent before the server is discovered gets none: repeat it.
    pub async fn call(&self, request: S::Request, within: Duration) -> Result<S::Response, CallError> {
        let service = || self.name.clone();
        let answer = tokio::time::timeout(within, self.inner.async_call_service(WireMessage(request))).await;
        let answer = answer.map_err(|_| CallError::NoAnswer { service: service(), within })?;
        let WireMessage(response) =
            answer.map_err(|error| CallError::Middleware { service: service(), reason: format!("{error:?}") })?;
        response.validate().map_err(|invalid| CallError::Invalid { service: service(), invalid })?;
        Ok(response)
    }
}
