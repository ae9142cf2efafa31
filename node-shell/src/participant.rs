//! The DDS participant and the nodes on it.
//!
//! One participant per process is the rule: each costs a thread, two sockets and a place among the
//! participants a host can discover (see `docs/ros.md`). Several nodes may share it.
//!
//! By default the participant stays on this machine. ROS 2's own default is the whole subnet; a machine that moves
//! should not obey every host on it. "Stays" means that it announces itself and sends on the loopback address only, and that
//! its sockets are bound to the loopback device (see `confine.rs`).

use crate::action::{self, ActionCaller, ActionOffer, RawActionServer};
use crate::caller::{Caller, Mapping};
use crate::confine::OpenFiles;
use crate::names::{self, NameError};
use crate::relay::Relay;
use crate::service::Service;
use crate::{Publisher, Range, RosArgs, Subscription, qos};
use linewright_msgs::{RosAction, RosMessage, RosService};
use ros2_client::{
    ActionTypeName, Context, MessageTypeName, Name, NodeName, NodeOptions, QosProfile, ServiceMapping, ServiceTypeName,
};
use rustdds::DomainParticipantBuilder;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// The participant or a node could not be made.
#[derive(Debug, Error)]
pub enum OpenError {
    /// DDS refused.
    #[error("cannot open ROS domain {domain_id}: {reason}")]
    Participant {
        domain_id: u16,
        /// The middleware's words.
        reason: String,
    },
    /// The node's name or namespace, as given or as remapped.
    #[error("node name: {0}")]
    Name(#[from] NameError),
    /// DDS refused the node.
    #[error("cannot create node {name}: {reason}")]
    Node {
        /// Full name.
        name: String,
        /// The middleware's words.
        reason: String,
    },
}

/// A topic could not be opened.
#[derive(Debug, Error)]
pub enum TopicError {
    /// The topic's name, as given or as remapped.
    #[error("topic name: {0}")]
    Name(#[from] NameError),
    /// DDS refused.
    #[error("cannot open topic {topic}: {reason}")]
    Middleware {
        /// Absolute name.
        topic: String,
        /// The middleware's words.
        reason: String,
    },
}

/// This process in a ROS domain.
pub struct Participant {
    context: Context,
    args: RosArgs,
    range: Range,
    relay: Option<Arc<Relay>>,
}

impl Participant {
    /// Joins the domain of `args`, on this machine only by default (`args.range`).
    pub fn open(args: &RosArgs) -> Result<Self, OpenError> {
        let failed = |reason: String| OpenError::Participant { domain_id: args.domain_id, reason };
        let range = args.range.unwrap_or(Range::Localhost);
        let builder = DomainParticipantBuilder::new(args.domain_id);
        let builder = match range {
            Range::Subnet => builder,
            Range::Localhost => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
            // No interface has this address, so nothing is announced anywhere.
            Range::Off => builder.with_only_networks([Ipv4Addr::UNSPECIFIED]).same_host_loopback(false),
        };
        // Before the participant, see there.
        let relay = match range {
            Range::Localhost => Some(Arc::new(Relay::start(args.domain_id).map_err(|e| failed(e.to_string()))?)),
            Range::Subnet | Range::Off => None,
        };
        let before = OpenFiles::now();
        let domain_participant = builder.build().map_err(|e| failed(e.to_string()))?;
        if range != Range::Subnet {
            match before.and_then(|before| before.confine_newer()) {
                Ok(sockets) => tracing::debug!("{sockets} sockets bound to the loopback device"),
                // The node works without it: it announces itself and sends on the loopback address only.
                Err(error) => tracing::warn!(
                    "the DDS sockets cannot be bound to the loopback device ({error}), which takes Linux 5.7: they listen on every \
                     network of this machine. Keep UDP ports 7400 to 65535 of this machine behind a firewall"
                ),
            }
        }
        let context = Context::from_domain_participant(domain_participant).map_err(|e| failed(e.to_string()))?;
        for warning in &args.warnings {
            tracing::warn!("{warning}");
        }
        Ok(Self { context, args: args.clone(), range, relay })
    }

    /// Creates a node; remap rules may rename it.
    pub fn node(&self, namespace: &str, name: &str) -> Result<RosNode, OpenError> {
        let (namespace, name) = names::identify(&self.args.remaps, namespace, name)?;
        let full = names::expand(&name, &namespace, &name)?;
        let failed = |reason: String| OpenError::Node { name: full.clone(), reason };
        let node_name = NodeName::new(&namespace, &name).map_err(|e| failed(e.to_string()))?;
        let options = NodeOptions::new().start_parameter_services(false).enable_rosout(false);
        let inner = self.context.new_node(node_name, options).map_err(|e| failed(e.to_string()))?;
        Ok(RosNode { inner, args: self.args.clone(), namespace, name, _relay: self.relay.clone() })
    }

    /// The domain joined.
    pub fn domain_id(&self) -> u16 {
        self.args.domain_id
    }

    /// Its discovery range.
    pub fn range(&self) -> Range {
        self.range
    }

    /// The number of this participant among those of this machine and domain, from 0. One number is
    /// taken by the discovery relay.
    pub fn number(&self) -> u16 {
        self.context.domain_participant().participant_id()
    }
}

/// Time for the middleware to take in what was opened, before the next thing is.
///
/// Its discovery holds the lock of its tables while it passes the endpoints of a topic that is new here to its event
/// loop, through a queue of 32. If that is full while the event loop waits to read the tables and another thread to
/// write into them, all three are deadlocked: seen where many nodes start at once, in the middle of opening one thing
/// after the other. With the queue empty at each opening it takes an unlikely burst to fill it; for that there is the
/// [`Watchdog`](crate::Watchdog).
const TAKE_IN: Duration = Duration::from_millis(2);

/// A ROS 2 node.
pub struct RosNode {
    inner: ros2_client::Node,
    args: RosArgs,
    namespace: String,
    name: String,
    // A node keeps working when its participant's handle is dropped, so it keeps the relay too.
    _relay: Option<Arc<Relay>>,
}

impl RosNode {
    /// Namespace after remaps.
    pub fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Base name after remaps.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The absolute name of a topic after expansion and remaps.
    pub fn resolve(&self, topic: &str) -> Result<String, NameError> {
        names::resolve(&self.args.remaps, topic, &self.namespace, &self.name)
    }

    /// Opens a topic for sending. `topic` may be absolute, relative or private (`~/…`).
    pub fn publisher<T: RosMessage>(&mut self, topic: &str, qos: QosProfile) -> Result<Publisher<T>, TopicError> {
        let (dds_topic, full) = self.topic::<T>(topic, &qos)?;
        match self.inner.create_publisher(&dds_topic, Some(qos)) {
            Ok(inner) => Ok(Publisher::new(inner, full)),
            Err(e) => Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        }
    }

    /// Opens a topic for receiving.
    pub fn subscription<T: RosMessage>(&mut self, topic: &str, qos: QosProfile) -> Result<Subscription<T>, TopicError> {
        let (dds_topic, full) = self.topic::<T>(topic, &qos)?;
        match self.inner.create_subscription(&dds_topic, Some(qos)) {
            Ok(inner) => Ok(Subscription::new(inner, full)),
            Err(e) => Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        }
    }

    /// Offers a service; the name expands as a topic's does. Hand it to [`serve`](crate::serve).
    pub fn service<S: RosService>(&mut self, name: &str) -> Result<Service<S>, TopicError> {
        let (dds_name, kind, full) = self.service_name::<S>(name)?;
        // The destination of an answer is handled in `service.rs`: this mapping adds nothing to the data.
        let mapping = ServiceMapping::Enhanced;
        match self.inner.create_server(mapping, &dds_name, &kind, qos::service(), qos::service()) {
            Ok(inner) => Ok(Service { inner: Arc::new(inner), name: full }),
            Err(e) => Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        }
    }

    /// Opens a service client.
    pub fn caller<S: RosService>(&mut self, name: &str, mapping: Mapping) -> Result<Caller<S>, TopicError> {
        let (dds_name, kind, full) = self.service_name::<S>(name)?;
        match self.inner.create_client(mapping.into(), &dds_name, &kind, qos::service(), qos::service()) {
            Ok(inner) => Ok(Caller { inner, name: full }),
            Err(e) => Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        }
    }

    /// Offers an action; the name expands as a topic's does. Hand it to [`serve_action`](crate::serve_action).
    pub fn action<A: RosAction>(&mut self, name: &str) -> Result<ActionOffer<A>, TopicError> {
        let (dds_name, full) = self.opening(name)?;
        let kind = ActionTypeName::new(A::PACKAGE, A::NAME);
        let mut server = |mapping| -> Result<RawActionServer<A>, TopicError> {
            let created = self.inner.create_action_server(mapping, &dds_name, &kind, action::server_qos());
            created.map_err(|e| TopicError::Middleware { topic: full.clone(), reason: e.to_string() })
        };
        let servers = [server(ServiceMapping::Enhanced)?, server(ServiceMapping::Cyclone)?];
        Ok(ActionOffer { servers, name: full })
    }

    /// Opens an action client.
    pub fn action_caller<A: RosAction>(&mut self, name: &str, mapping: Mapping) -> Result<ActionCaller<A>, TopicError> {
        let (dds_name, full) = self.opening(name)?;
        let kind = ActionTypeName::new(A::PACKAGE, A::NAME);
        match self.inner.create_action_client(mapping.into(), &dds_name, &kind, action::client_qos()) {
            Ok(inner) => Ok(ActionCaller { inner, name: full }),
            Err(e) => Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        }
    }

    fn service_name<S: RosService>(&self, name: &str) -> Result<(Name, ServiceTypeName, String), TopicError> {
        let (name, full) = self.opening(name)?;
        Ok((name, ServiceTypeName::new(S::PACKAGE, S::NAME), full))
    }

    /// The name of what is about to be opened; everything that is opened comes by here.
    fn opening(&self, name: &str) -> Result<(Name, String), TopicError> {
        let full = self.resolve(name)?;
        let name = match Name::parse(&full) {
            Ok(name) => name,
            Err(e) => return Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        };
        std::thread::sleep(TAKE_IN);
        Ok((name, full))
    }

    /// Publishers now known on a topic, this process's own included. For displays and tests: a dead
    /// one is counted until its lease runs out.
    pub fn publisher_count(&self, topic: &str) -> Result<usize, NameError> {
        Ok(self.inner.publisher_count(&self.resolve(topic)?))
    }

    /// Subscriptions now known on a topic, counted in the same way.
    pub fn subscription_count(&self, topic: &str) -> Result<usize, NameError> {
        Ok(self.inner.subscription_count(&self.resolve(topic)?))
    }

    fn topic<T: RosMessage>(&self, topic: &str, qos: &QosProfile) -> Result<(rustdds::Topic, String), TopicError> {
        let (name, full) = self.opening(topic)?;
        let type_name = MessageTypeName::new(T::PACKAGE, T::NAME);
        match self.inner.create_topic(&name, type_name, qos) {
            Ok(dds_topic) => Ok((dds_topic, full)),
            Err(e) => Err(TopicError::Middleware { topic: full, reason: e.to_string() }),
        }
    }
}
