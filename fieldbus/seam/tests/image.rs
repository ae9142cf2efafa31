//! Images of inputs and outputs.

use linewright_fieldbus_seam::{InputImage, gather, scatter};
use linewright_line::{InputId, OutputId, Tick};

#[test]
fn bits_go_where_the_map_says() {
    let map = [Some(InputId(5)), None, Some(InputId(127))];
    assert_eq!(gather(0b111, &map), 1 << 5 | 1 << 127);
    assert_eq!(gather(0b010, &map), 0);
    let map = [Some(OutputId(3)), None, Some(OutputId(0))];
    assert_eq!(scatter(u128::MAX, &map), 0b101);
    assert_eq!(scatter(1, &map), 0b100);
}

#[test]
fn an_image_that_becomes_invalid_counts_a_loss() {
    let at = Tick::from_millis;
    let up = InputImage::NEVER.followed_by(at(5), 1, true, Some(at(5)));
    assert_eq!((up.since, up.losses), (at(5), 0));
    let on = up.followed_by(at(7), 3, true, None);
    assert_eq!((on.bits, on.since, on.updated), (3, at(5), at(5)));
    let lost = on.followed_by(at(9), 3, false, None);
    assert_eq!((lost.since, lost.losses), (at(9), 1));
    assert_eq!(lost.followed_by(at(11), 3, false, None).losses, 1);
}
