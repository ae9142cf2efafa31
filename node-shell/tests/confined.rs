//! Datagrams from another machine at the DDS ports of a participant that stays on this one: the kernel drops them.

use std::io::ErrorKind;
use std::net::UdpSocket;
use std::time::Duration;

use linewright_node_shell::{Participant, Range, RosArgs};

use crate::namespace::{OtherNamespace, is_alone, run_inside, skip};

#[test]
fn what_comes_by_another_device_reaches_no_socket_of_a_participant() {
    run_inside("datagrams from another machine", "confined::inside_the_namespace");
}

/// The ports of the first participant of domain 7, for discovery and for data (RTPS 2.5, 9.6.2.3).
const PORTS: [u16; 2] = [7400 + 250 * 7 + 10, 7400 + 250 * 7 + 11];

#[ignore = "started by inside_the_namespace"]
#[test]
fn beside_it() {
    if !is_alone() {
        return skip("not in a namespace of its own");
    }
    for port in PORTS {
        let socket = UdpSocket::bind("10.77.0.2:0").expect("an address");
        socket.connect(("10.77.0.1", port)).expect("an address");
        socket.set_read_timeout(Some(Duration::from_millis(500))).expect("a timeout");
        socket.send(b"RTPS").expect("sent");
        // Where no socket takes the datagram, the kernel of the other machine reports the port unreachable.
        let answer = socket.recv(&mut [0; 8]).expect_err("DDS sends no answer");
        let is_refused = answer.kind() == ErrorKind::ConnectionRefused;
        println!("{}", if is_refused { "refused" } else { "taken" });
    }
}

#[ignore = "started by what_comes_by_another_device_reaches_no_socket_of_a_participant"]
#[test]
fn inside_the_namespace() {
    if !is_alone() {
        return skip("not in a namespace of its own");
    }
    let other = OtherNamespace::start();
    let sent = || {
        let output = other.test("confined::beside_it").output().expect("started");
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8_lossy(&output.stdout);
        [text.matches("taken").count(), text.matches("refused").count()]
    };
    // Sockets of every address take them: these are the ports, and the way is open.
    let open = PORTS.map(|port| UdpSocket::bind(("0.0.0.0", port)).expect("a free port"));
    assert_eq!(sent(), [2, 0]);
    drop(open);
    let args = RosArgs { domain_id: 7, range: Some(Range::Localhost), ..RosArgs::default() };
    let participant = Participant::open(&args).expect("a participant");
    assert_eq!(participant.number(), 0, "its ports are those");
    for port in PORTS {
        assert!(UdpSocket::bind(("0.0.0.0", port)).is_err(), "the participant has port {port}");
    }
    assert_eq!(sent(), [0, 2]);
}
