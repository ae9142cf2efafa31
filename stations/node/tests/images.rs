//! The inputs of a station behind the gateway, as a message.

use linewright_msgs::ProcessImage;
use linewright_station_node::inputs_from_message;

#[test]
fn inputs_of_another_description_are_not_taken() {
    let mut message = ProcessImage { boot_id: 5, sequence: 6, description: 7, valid: true, ..ProcessImage::default() };
    message.set_word(0b101);
    let inputs = inputs_from_message(7, &message).expect("of the same description");
    assert_eq!((inputs.boot_id, inputs.sequence, inputs.bits, inputs.valid), (5, 6, 0b101, true));
    let error = inputs_from_message(8, &message).expect_err("of another one").to_string();
    assert!(error.starts_with("the coordinator runs with another description"), "{error}");
}
