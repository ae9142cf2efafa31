//! Services between two participants of this machine, in both forms of requests.

use std::time::Duration;

use linewright_msgs::{
    CORead, COReadID, CoReadIdRequest, CoReadIdResponse, CoReadRequest, CoReadResponse, Trigger, TriggerRequest,
    TriggerResponse,
};
use linewright_node_shell::{Caller, Mapping, Participant, RosArgs, RosNode, serve};
use tokio::sync::mpsc;

/// Domains 89 to 100, away from those of the other tests.
fn node(test: u16, name: &str) -> RosNode {
    let domain_id = 89 + (std::process::id() % 4) as u16 * 3 + test;
    let participant = Participant::open(&RosArgs { domain_id, ..RosArgs::default() }).expect("participant");
    participant.node("/line", name).expect("node")
}

/// Repeats a request until it is answered: one sent before discovery is lost.
async fn ask<S: linewright_msgs::RosService>(caller: &Caller<S>, request: &S::Request) -> S::Response {
    for _ in 0..40 {
        if let Ok(response) = caller.call(request.clone(), Duration::from_millis(500)).await {
            return response;
        }
    }
    panic!("no answer");
}

#[tokio::test]
async fn requests_are_answered_in_the_way_they_came() {
    let mut server = node(0, "server");
    let (to, mut from) = mpsc::channel(16);
    let read = server.service::<CORead>("drill_io/sdo_read").expect("service");
    let reads = serve(read, to.clone(), |asked, reply| (Some((asked, reply)), None, None));
    let read_id = server.service::<COReadID>("~/sdo_read").expect("service");
    let ids = serve(read_id, to.clone(), |asked, reply| (None, Some((asked, reply)), None));
    let reset = server.service::<Trigger>("drill_io/nmt_reset_node").expect("service");
    let resets = serve(reset, to, |_, reply| (None, None, Some(reply)));
    tokio::spawn(async move {
        let _tasks = (reads, ids, resets);
        while let Some((read, id, reset)) = from.recv().await {
            if let Some((asked, reply)) = read {
                let CoReadRequest { index, subindex } = asked;
                reply.send(CoReadResponse { success: true, data: u32::from(index) << 8 | u32::from(subindex) });
            }
            if let Some((asked, reply)) = id {
                let data = u32::from(asked.nodeid) << 24 | u32::from(asked.index) << 8 | u32::from(asked.subindex);
                reply.send(CoReadIdResponse { success: asked.canopen_datatype == 7, data });
            }
            if let Some(reply) = reset {
                reply.send(TriggerResponse { success: false, message: "not now".to_owned() });
            }
        }
    });
    let mut client = node(0, "client");
    for mapping in [Mapping::Enhanced, Mapping::Cyclone] {
        let read = client.caller::<CORead>("/line/drill_io/sdo_read", mapping).expect("caller");
        let answer = ask(&read, &CoReadRequest { index: 0x1018, subindex: 1 }).await;
        assert_eq!(answer, CoReadResponse { success: true, data: 0x10_1801 }, "{mapping:?}");
        let read = client.caller::<COReadID>("/line/server/sdo_read", mapping).expect("caller");
        let request = CoReadIdRequest { nodeid: 0x21, index: 0x6000, subindex: 2, canopen_datatype: 7 };
        let answer = ask(&read, &request).await;
        assert_eq!(answer, CoReadIdResponse { success: true, data: 0x2160_0002 }, "{mapping:?}");
        let reset = client.caller::<Trigger>("drill_io/nmt_reset_node", mapping).expect("caller");
        let answer = ask(&reset, &TriggerRequest::default()).await;
        assert_eq!((answer.success, answer.message.as_str()), (false, "not now"), "{mapping:?}");
    }
}
