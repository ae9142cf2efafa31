//! Transfers on an undisturbed channel: the frames of the standard, and every length.

use super::*;

fn read(data: &[u8], mode: TransferMode) -> (Vec<String>, Vec<u8>) {
    let mut pair = ClientServerPair::new(SdoClient::upload(NAME, options(mode)), ByteDictionary::with(NAME, data));
    let result = pair.run().unwrap();
    (pair.log, result)
}

fn write(data: &[u8], mode: TransferMode) -> (Vec<String>, Vec<u8>) {
    let mut pair = ClientServerPair::new(SdoClient::download(OTHER, data, options(mode)), ByteDictionary::default());
    assert_eq!(pair.run(), Ok(Vec::new()));
    assert_eq!(pair.store.writes, 1);
    (pair.log, pair.store.objects.remove(&OTHER).unwrap())
}

#[test]
fn up_to_four_bytes_are_one_frame_each_way() {
    assert_eq!(
        read(&[1, 2, 3, 4], TransferMode::Auto).0,
        ["40081000", "  4308100001020304"].map(|s| {
            // Zeros at the end are left away in the log.
            s.trim_end_matches("00").to_owned()
        })
    );
    assert_eq!(read(&[7], TransferMode::Auto), (vec!["400810".to_owned(), "  4F08100007".to_owned()], vec![7]));
    assert_eq!(
        write(&[7, 8], TransferMode::Auto),
        (vec!["2B0020010708".to_owned(), "  60002001".to_owned()], vec![7, 8])
    );
}

#[test]
fn more_goes_in_segments_with_a_toggle_bit() {
    let (log, data) = read(b"Linewright I/O", TransferMode::Auto);
    assert_eq!(
        log,
        [
            "400810",
            "  410810000E", // 14 bytes
            "60",
            "  004C696E65777269",
            "70",
            "  1167687420492F4F",
        ]
    );
    assert_eq!(data, b"Linewright I/O");
    let (log, data) = write(b"123456789", TransferMode::Auto);
    assert_eq!(
        log,
        [
            "2100200109",
            "  60002001", // 9 bytes
            "0031323334353637",
            "  20",
            "1B3839",
            "  30",
        ]
    );
    assert_eq!(data, b"123456789");
}

#[test]
fn much_goes_in_blocks_with_a_checksum() {
    let (log, data) = write(&[0x55; 70], TransferMode::Auto);
    let (head, tail) = (&log[..3], &log[log.len() - 4..]);
    assert_eq!(head, ["C600200146", "  A40020017F", "0155555555555555"]);
    let crc = u16::from_le_bytes([raw(&tail[2])[1], raw(&tail[2])[2]]);
    assert_eq!(tail, ["8A55555555555555", "  A20A7F", &format!("C1{:02X}{:02X}", crc as u8, crc >> 8), "  A1"]);
    assert_eq!(data, [0x55; 70]);
    // To read, the length is requested first.
    let (log, data) = read(&[0x55; 71], TransferMode::Auto);
    assert_eq!(log[..6], ["400810", "  4108100047", "8008100000000008", "A40810007F", "  C608100047", "A3"]);
    let tail = &log[log.len() - 4..];
    assert_eq!(tail[..2], ["  8B55", "A20B7F"]);
    assert!(tail[2].starts_with("  D9") && tail[3] == "A1", "6 bytes of the last segment do not count: {tail:?}");
    assert_eq!(data, [0x55; 71]);
}

#[test]
fn the_checksum_is_that_of_the_standard() {
    // The check value of CRC-16/XMODEM, polynomial 1021h.
    assert_eq!(block::crc(b"123456789"), 0x31C3);
}

#[test]
fn every_length_arrives_both_ways_in_every_mode() {
    for len in (0..150).chain([889, 890, 895, 896, 1778, 1999, 2000, 4096]) {
        let data = pattern(len);
        for mode in [TransferMode::Auto, TransferMode::Segmented, TransferMode::Block] {
            assert_eq!(read(&data, mode).1, data, "reading {len} bytes, {mode:?}");
            assert_eq!(write(&data, mode).1, data, "writing {len} bytes, {mode:?}");
        }
    }
}

#[test]
fn a_burst_is_bounded_and_the_rest_waits() {
    let mut client =
        SdoClient::download(OTHER, pattern(700), TransferOptions { burst: 4, ..TransferOptions::default() });
    let mut out = Vec::new();
    let now = Tick::from_millis(1);
    client.start(now, &mut out);
    out.clear();
    client.handle(now, &raw("A40020017F"), &mut out);
    assert_eq!(out.len(), 4);
    assert_eq!(client.next_deadline(), Some(after(now, 1)));
    client.poll(now, &mut out);
    assert_eq!(out.len(), 4, "not before its time");
    client.poll(after(now, 1), &mut out);
    assert_eq!((out.len(), out[7][0]), (8, 8));
}

#[test]
fn a_client_that_does_not_say_how_many_bytes_means_as_many_as_the_object_has() {
    let mut store = ByteDictionary::with(OTHER, &[0, 0]);
    let mut server = SdoServer::new(64);
    let mut out = Vec::new();
    server.handle(Tick::ZERO, &raw("22002001AABB"), &mut store, &mut out);
    assert_eq!((text(&out[0]), &store.objects[&OTHER]), ("60002001".to_owned(), &vec![0xAA, 0xBB]));
}
