//! Round trips, golden bytes, and random ones.

use proptest::prelude::*;

use super::*;

fn node(id: u8) -> NodeId {
    NodeId::new(id).unwrap()
}

#[test]
fn messages_have_the_bytes_of_the_standard() {
    let golden = [
        ("000#0104", CanopenMessage::Nmt { command: NmtCommand::Start, node: Some(node(4)) }),
        ("000#8200", CanopenMessage::Nmt { command: NmtCommand::ResetCommunication, node: None }),
        ("080#", CanopenMessage::Sync { counter: None }),
        ("080#07", CanopenMessage::Sync { counter: Some(7) }),
        (
            "084#3081110000000000",
            CanopenMessage::Emergency {
                node: node(4),
                emergency: Emergency { code: HEARTBEAT_LOST, register: 0x11, vendor: [0; 5] },
            },
        ),
        ("181#0102", CanopenMessage::Tpdo1 { node: node(1), payload: Payload::from_bits(0x0201, 16) }),
        ("27F#80", CanopenMessage::Rpdo1 { node: node(127), payload: Payload::from_bits(0x80, 8) }),
        (
            "604#2B17100032000000",
            CanopenMessage::SdoRequest { node: node(4), raw: [0x2B, 0x17, 0x10, 0x00, 0x32, 0x00, 0x00, 0x00] },
        ),
        (
            "584#8000100000000206",
            CanopenMessage::SdoResponse { node: node(4), raw: [0x80, 0x00, 0x10, 0x00, 0x00, 0x00, 0x02, 0x06] },
        ),
        ("704#00", CanopenMessage::Heartbeat { node: node(4), state: NmtState::BootUp }),
        ("77F#05", CanopenMessage::Heartbeat { node: node(127), state: NmtState::Operational }),
        ("704#42", CanopenMessage::Heartbeat { node: node(4), state: NmtState::Unknown(0x42) }),
    ];
    for (text, message) in golden {
        assert_eq!(message.encode().to_string(), text);
        assert_eq!(CanopenMessage::decode(&text.parse().unwrap()), Ok(message), "{text}");
    }
}

#[test]
fn malformed_frames_say_what_was_expected() {
    let cases = [
        ("000#01", "COB-ID 000h: 1 data bytes, expected 2"),
        ("000#0180", "COB-ID 000h: node id is 0x80, expected 0 to 127"),
        ("084#30", "COB-ID 084h: 1 data bytes, expected 8"),
        ("704#", "COB-ID 704h: 0 data bytes, expected 1"),
        ("704#R1", "704h is a remote request"),
        ("00000704#05", "identifier 00000704h is extended, CANopen uses 11-bit identifiers"),
        ("20000040#0000000000000000", "error frame, classes 0x40"),
        ("180#00", "COB-ID 180h has no meaning here"),
        ("7E5#00", "COB-ID 7E5h has no meaning here"),
        ("604#40001000", "COB-ID 604h: 4 data bytes, expected 8"),
        ("584#", "COB-ID 584h: 0 data bytes, expected 8"),
    ];
    for (text, expected) in cases {
        let error = CanopenMessage::decode(&text.parse().unwrap()).unwrap_err();
        assert_eq!(error.to_string(), expected, "{text}");
    }
}

prop_compose! {
    fn any_node()(id in 1u8..=127) -> NodeId { node(id) }
}

fn any_message() -> impl Strategy<Value = CanopenMessage> {
    let payload = (any::<u64>(), 1usize..=64).prop_map(|(bits, count)| Payload::from_bits(bits, count)).boxed();
    let nmt_node = prop::option::of(any_node());
    prop_oneof![
        (any::<u8>(), nmt_node)
            .prop_map(|(code, node)| CanopenMessage::Nmt { command: NmtCommand::from_code(code), node }),
        any::<Option<u8>>().prop_map(|counter| CanopenMessage::Sync { counter }),
        (any_node(), any::<u16>(), any::<u8>(), any::<[u8; 5]>()).prop_map(|(node, code, register, vendor)| {
            CanopenMessage::Emergency { node, emergency: Emergency { code, register, vendor } }
        }),
        (any_node(), payload.clone()).prop_map(|(node, payload)| CanopenMessage::Tpdo1 { node, payload }),
        (any_node(), payload).prop_map(|(node, payload)| CanopenMessage::Rpdo1 { node, payload }),
        (any_node(), any::<[u8; 8]>()).prop_map(|(node, raw)| CanopenMessage::SdoRequest { node, raw }),
        (any_node(), any::<[u8; 8]>()).prop_map(|(node, raw)| CanopenMessage::SdoResponse { node, raw }),
        (any_node(), any::<u8>())
            .prop_map(|(node, code)| CanopenMessage::Heartbeat { node, state: NmtState::from_code(code) }),
    ]
}

proptest! {
    #[test]
    fn every_message_round_trips(message in any_message()) {
        prop_assert_eq!(CanopenMessage::decode(&message.encode()), Ok(message));
    }

    #[test]
    fn any_frame_is_a_message_or_an_error(cob_id in 0u16..0x800, data in prop::collection::vec(any::<u8>(), 0..=8)) {
        let frame = Frame::data_frame(cob_id, &data).unwrap();
        match CanopenMessage::decode(&frame) {
            // A decoded message decodes the same way again; reserved bytes may have been dropped.
            Ok(message) => prop_assert_eq!(CanopenMessage::decode(&message.encode()), Ok(message)),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }

    #[test]
    fn payload_bits_are_those_sent(bits in any::<u64>(), count in 1usize..=64) {
        let payload = Payload::from_bits(bits, count);
        prop_assert_eq!(payload.bytes().len(), count.div_ceil(8));
        for i in 0..count {
            prop_assert_eq!(payload.bytes()[i / 8] >> (i % 8) & 1 == 1, bits >> i & 1 == 1);
        }
    }
}
