//! A node that is none of the line's: it asks services.

use std::time::{Duration, Instant};

use linewright_msgs::RosService;
use linewright_node_shell::{Caller, Mapping, Participant, RosArgs, RosNode};
use tokio::runtime::Runtime;

use crate::support::PATIENCE;
use crate::support::rig::Rig;

/// Anybody on this machine.
pub struct Stranger {
    pub runtime: Runtime,
    pub node: RosNode,
}

impl Stranger {
    pub fn join(rig: &Rig) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        let args = RosArgs { domain_id: rig.domain(), ..RosArgs::default() };
        let participant = Participant::open(&args).expect("a participant");
        Stranger { runtime, node: participant.node("/elsewhere", "stranger").expect("a node") }
    }

    pub fn caller<S: RosService>(&mut self, service: &str) -> Caller<S> {
        self.node.caller(service, Mapping::Enhanced).expect("a service")
    }

    /// Repeats a request until it is answered: one sent before discovery is lost.
    pub fn ask<S: RosService>(&self, caller: &Caller<S>, request: &S::Request) -> S::Response {
        let end = Instant::now() + PATIENCE;
        loop {
            match self.runtime.block_on(caller.call(request.clone(), Duration::from_secs(2))) {
                Ok(response) => return response,
                Err(error) => assert!(Instant::now() < end, "{error}"),
            }
        }
    }
}
