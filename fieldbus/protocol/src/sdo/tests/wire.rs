//! Every eight bytes are a request or none, a response or none; and what is encoded is decoded as the same.

use proptest::prelude::*;

use super::super::wire::*;

proptest! {
    #[test]
    fn what_is_decoded_is_the_same_after_another_round(raw in any::<[u8; 8]>()) {
        // Reserved bits are not kept: the bytes may differ, their meaning may not.
        if let Some(request) = ClientFrame::decode(&raw) {
            prop_assert_eq!(ClientFrame::decode(&request.encode()), Some(request));
        }
        if let Some(response) = ServerFrame::decode(&raw) {
            prop_assert_eq!(ServerFrame::decode(&response.encode()), Some(response));
        }
        if let Some(segment) = BlockSegment::decode(&raw) {
            prop_assert_eq!(segment.encode(), raw);
        }
    }
}
