//! What the scenarios have found and the code under test does not do yet.
//!
//! Each is a minimal story that fails; `cargo test -p linewright-tests known_gaps -- --ignored` shows them.
//! Whoever closes a gap takes the `ignore` off and moves the story to its neighbours.

use linewright_node_shell::NewestBySequence;

/// A writer that is restarted within the time a message is on its way, and a reader that does not know its earlier
/// life (it has just been started itself, or that life was a short one): the last word of the earlier life comes after
/// the first word of the living one, counts as a newer life, and the reader is deaf from then on.
#[test]
#[ignore = "boot ids have no order, so a boot never heard before counts as the newest"]
fn the_last_word_of_a_short_life_does_not_deafen_its_readers() {
    let mut newest = NewestBySequence::new();
    assert!(newest.offer(1, 500).is_newest());
    assert!(newest.offer(3, 1).is_newest());
    newest.offer(2, 1);
    assert!(newest.offer(3, 2).is_newest(), "the writer that lives is heard");
}
