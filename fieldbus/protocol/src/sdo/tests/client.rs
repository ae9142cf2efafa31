//! The client against a server that a test plays by hand: every way a transfer ends without result.

use super::*;

/// Plays a server. Each line is what it sends, and what the client is to send thereupon, separated by spaces; a line
/// that begins with a number of milliseconds and `ms` lets time pass instead.
fn play(mut client: SdoClient, lines: &[(&str, &str)]) -> Option<Result<Vec<u8>, TransferError>> {
    let mut now = Tick::from_millis(1);
    let mut out = Vec::new();
    let mut result = None;
    client.start(now, &mut out);
    for (said, expected) in lines {
        let progress = if said.is_empty() {
            TransferProgress::Busy
        } else if let Some(millis) = said.strip_suffix("ms") {
            now = after(now, millis.parse().unwrap());
            client.poll(now, &mut out)
        } else {
            client.handle(now, &raw(said), &mut out)
        };
        let sent: Vec<String> = out.drain(..).map(|raw| text(&raw)).collect();
        assert_eq!(sent.join(" "), *expected, "after {said}");
        if let TransferProgress::Done(ended) = progress {
            assert_eq!(result.replace(ended), None, "it ends once");
            assert_eq!(client.next_deadline(), None);
        } else {
            assert_eq!(client.next_deadline().is_none(), result.is_some());
        }
    }
    result
}

fn read(lines: &[(&str, &str)]) -> Option<Result<Vec<u8>, TransferError>> {
    play(SdoClient::upload(NAME, TransferOptions::default()), lines)
}

fn read_with(options: TransferOptions, lines: &[(&str, &str)]) -> TransferFailure {
    play(SdoClient::upload(NAME, options), lines).unwrap().unwrap_err().cause
}

fn write(len: usize, mode: TransferMode, lines: &[(&str, &str)]) -> Option<Result<Vec<u8>, TransferError>> {
    play(SdoClient::download(OTHER, vec![0x55; len], options(mode)), lines)
}

fn cause(result: Option<Result<Vec<u8>, TransferError>>) -> TransferFailure {
    result.expect("it has ended").expect_err("without result").cause
}

const ASKED: (&str, &str) = ("", "400810");
/// Ten bytes are announced in segments.
const TEN: (&str, &str) = ("410810000A", "60");
/// Blocks are requested at once.
const BLOCKS: (&str, &str) = ("", "A40810007F");
const BLOCK_WRITE: (&str, &str) = ("", "C600200114");
const SEGMENTS_OF_20: &str = "0155555555555555 0255555555555555 83555555555555";

#[test]
fn the_device_refuses_at_once_or_on_the_way() {
    let refused = TransferFailure::Refused(Abort::NO_OBJECT);
    assert_eq!(cause(read(&[ASKED, ("8008100000000206", "")])), refused);
    assert_eq!(cause(read(&[ASKED, TEN, ("8008100000000206", "")])), refused);
    // Within a transfer no other can be meant, whatever object the abort names.
    assert_eq!(cause(read(&[ASKED, TEN, ("8000000000000206", "")])), refused);
    let one = ("", "2F00200155");
    assert_eq!(cause(write(1, TransferMode::Auto, &[one, ("8000200100000206", "")])), refused);
    let (head, first) = (("", "2100200114"), ("60002001", "0055555555555555"));
    assert_eq!(cause(write(20, TransferMode::Auto, &[head, first, ("8000200100000206", "")])), refused);
    let blocks = ("A40020017F", SEGMENTS_OF_20);
    assert_eq!(cause(write(20, TransferMode::Block, &[BLOCK_WRITE, blocks, ("8000200100000206", "")])), refused);
    let all = ("A2037F", "C5CE6E");
    assert_eq!(cause(write(20, TransferMode::Block, &[BLOCK_WRITE, blocks, all, ("8000200100000206", "")])), refused);
    let mode = options(TransferMode::Block);
    assert_eq!(read_with(mode, &[BLOCKS, ("C60810000A", "A3"), ("8008100000000206", "")]), refused);
    let error = read(&[ASKED, ("8008100000000206", "")]).unwrap().unwrap_err();
    assert_eq!(error.to_string(), "object 1008h:00: refused: 06020000h (no such object)");
}

#[test]
fn the_first_frame_is_repeated_and_no_other() {
    let silent = |done, asked| TransferFailure::Silent { waited: Duration::from_secs(1), done, asked };
    let again = ("1000ms", "400810");
    let timeout = ("1000ms", "8008100000000405");
    assert_eq!(cause(read(&[ASKED, ("999ms", ""), ("1ms", "400810"), again, timeout])), silent(0, 3));
    assert_eq!(cause(read(&[ASKED, TEN, timeout])), silent(0, 1));
    assert_eq!(cause(read(&[ASKED, TEN, ("0041424344454647", "70"), timeout])), silent(7, 1));
    let timeout = ("1000ms", "8000200100000405");
    let (head, first) = (("", "2100200114"), ("60002001", "0055555555555555"));
    assert_eq!(cause(write(20, TransferMode::Auto, &[head, first, timeout])), silent(0, 1));
    let blocks = ("A40020017F", SEGMENTS_OF_20);
    assert_eq!(cause(write(20, TransferMode::Block, &[BLOCK_WRITE, blocks, timeout])), silent(0, 1));
    let all = ("A2037F", "C5CE6E");
    assert_eq!(cause(write(20, TransferMode::Block, &[BLOCK_WRITE, blocks, all, timeout])), silent(20, 1));
    let error = read(&[ASKED, again, again, ("1000ms", "8008100000000405")]).unwrap().unwrap_err();
    assert_eq!(error.to_string(), "object 1008h:00: no answer within 1000 ms, asked 3 times");
    let error = read(&[ASKED, TEN, ("0041424344454647", "70"), ("1000ms", "8008100000000405")]).unwrap().unwrap_err();
    assert_eq!(error.to_string(), "object 1008h:00: no answer within 1000 ms after 7 bytes");
}

#[test]
fn a_silent_block_is_asked_for_again_and_then_given_up() {
    let start = ("C60810001E", "A3");
    let first = ("0141424344454647", "");
    // The second segment and the end were lost: what has come is acknowledged, and the rest comes in a new block.
    let resumed = [BLOCKS, start, first, ("250ms", "A2017F"), ("0148494A4B4C4D4E", ""), ("249ms", "")];
    assert_eq!(play(SdoClient::upload(NAME, options(TransferMode::Block)), &resumed), None);
    let stall = ("250ms", "A2007F");
    let lines = [BLOCKS, start, first, ("250ms", "A2017F"), stall, stall, stall, ("250ms", "8008100000000405")];
    let silent = TransferFailure::Silent { waited: Duration::from_secs(1), done: 7, asked: 1 };
    assert_eq!(read_with(options(TransferMode::Block), &lines), silent);
    // All has come but the end frame.
    let lines = [BLOCKS, ("C608100007", "A3"), ("8141424344454647", "A2017F"), ("1000ms", "8008100000000405")];
    assert_eq!(read_with(options(TransferMode::Block), &lines), silent);
}

#[test]
fn a_segment_twice_or_missing_is_a_toggle_error() {
    let abort = "8008100000000305";
    assert_eq!(cause(read(&[ASKED, TEN, ("1041424344454647", abort)])), TransferFailure::Toggle { done: 0 });
    let first = ("0041424344454647", "70");
    assert_eq!(cause(read(&[ASKED, TEN, first, ("0041424344454647", abort)])), TransferFailure::Toggle { done: 7 });
    let (head, first) = (("", "2100200114"), ("60002001", "0055555555555555"));
    let second = ("20", "1055555555555555");
    let abort = "8000200100000305";
    assert_eq!(
        cause(write(20, TransferMode::Auto, &[head, first, ("30", abort)])),
        TransferFailure::Toggle { done: 0 }
    );
    assert_eq!(
        cause(write(20, TransferMode::Auto, &[head, first, second, ("20", abort)])),
        TransferFailure::Toggle { done: 7 }
    );
    // Empty segments lead nowhere.
    assert_eq!(
        cause(read(&[ASKED, ("400810", "60"), ("0E", "8008100000000305")])),
        TransferFailure::Toggle { done: 0 }
    );
}

#[test]
fn numbers_of_segments_that_cannot_be() {
    let blocks = ("A40020017F", SEGMENTS_OF_20);
    let abort = "8000200103000405";
    assert_eq!(
        cause(write(20, TransferMode::Block, &[BLOCK_WRITE, blocks, ("A2047F", abort)])),
        TransferFailure::Sequence { number: 4 }
    );
    // Nothing arrives, again and again.
    let none = ("A2007F", SEGMENTS_OF_20);
    let lines = [BLOCK_WRITE, blocks, none, none, none, ("A2007F", abort)];
    assert_eq!(cause(write(20, TransferMode::Block, &lines)), TransferFailure::Sequence { number: 0 });
    let abort = ("00", "8008100003000405");
    assert_eq!(
        read_with(options(TransferMode::Block), &[BLOCKS, ("C60810001E", "A3"), abort]),
        TransferFailure::Sequence { number: 0 }
    );
    // Blocks that end without anything new.
    let (none, abort) = (("FF", "A2007F"), ("FF", "8008100003000405"));
    let lines = [BLOCKS, ("C60810001E", "A3"), none, none, none, abort];
    assert_eq!(read_with(options(TransferMode::Block), &lines), TransferFailure::Sequence { number: 127 });
}

#[test]
fn block_sizes_that_cannot_be() {
    for (frame, size) in [("A4002001", 0), ("A400200180", 128)] {
        let lines = [BLOCK_WRITE, (frame, "8000200102000405")];
        assert_eq!(cause(write(20, TransferMode::Block, &lines)), TransferFailure::BlockSize { size });
    }
    let lines = [BLOCK_WRITE, ("A40020017F", SEGMENTS_OF_20), ("A201", "8000200102000405")];
    assert_eq!(cause(write(20, TransferMode::Block, &lines)), TransferFailure::BlockSize { size: 0 });
}

#[test]
fn a_wrong_checksum_or_length_is_never_a_result() {
    let head = [BLOCKS, ("C608100007", "A3"), ("8141424344454647", "A2017F")];
    let with = |end| read_with(options(TransferMode::Block), &[head[0], head[1], head[2], end]);
    let computed = block::crc(b"ABCDEFG");
    assert_eq!(with(("C13412", "8008100004000405")), TransferFailure::Crc { sent: 0x1234, computed });
    assert_eq!(with(("C5", "8008100013000706")), TransferFailure::Length { announced: 7, came: 6 });
    let last = |frame, abort| cause(read(&[ASKED, TEN, ("0041424344454647", "70"), (frame, abort)]));
    assert_eq!(last("1B4142", "8008100013000706"), TransferFailure::Length { announced: 10, came: 9 });
    assert_eq!(last("1741424344", "8008100012000706"), TransferFailure::Length { announced: 10, came: 11 });
    let lines = [BLOCKS, ("C608100007", "A3"), ("0141424344454647", ""), ("0241", "8008100012000706")];
    assert_eq!(read_with(options(TransferMode::Block), &lines), TransferFailure::Length { announced: 7, came: 8 });
}

#[test]
fn no_more_is_taken_than_was_said() {
    let limit = |mode| TransferOptions { len_max: 10, mode, ..TransferOptions::default() };
    let too_long = TransferFailure::TooLong { len_max: 10 };
    let abort = "8008100005000405";
    assert_eq!(read_with(limit(TransferMode::Auto), &[ASKED, ("410810000B", abort)]), too_long);
    let lines = [ASKED, ("400810", "60"), ("0041424344454647", "70"), ("1041424344454647", abort)];
    assert_eq!(read_with(limit(TransferMode::Auto), &lines), too_long);
    assert_eq!(read_with(limit(TransferMode::Block), &[BLOCKS, ("C60810000B", abort)]), too_long);
    let segment = |text| (text, "");
    let lines = [BLOCKS, ("C40810", "A3"), segment("0141"), segment("0241"), ("0341", abort)];
    assert_eq!(read_with(limit(TransferMode::Block), &lines), too_long);
    let lines = [BLOCKS, ("C40810", "A3"), segment("0141"), ("8241", "A2027F"), ("C1", abort)];
    assert_eq!(read_with(limit(TransferMode::Block), &lines), too_long);
}

#[test]
fn answers_that_fit_nothing() {
    let command = |command, done| TransferFailure::Command { command, done };
    let abort = "8008100001000405";
    assert_eq!(cause(read(&[ASKED, TEN, ("20", abort)])), command(0x20, 0));
    assert_eq!(cause(read(&[ASKED, TEN, ("E0", abort)])), command(0xE0, 0));
    assert_eq!(cause(read(&[ASKED, TEN, ("0041424344454647", "70"), ("410810000A", abort)])), command(0x41, 7));
    let lines = [BLOCKS, ("C608100007", "A3"), ("8141424344454647", "A2017F"), ("8141424344454647", abort)];
    assert_eq!(read_with(options(TransferMode::Block), &lines), command(0x81, 7));
}

#[test]
fn what_others_ask_is_ignored_at_first_and_later_the_end() {
    let foreign = ("4F00200101", "");
    let noise = [("20", ""), ("A1", ""), ("E0", ""), ("8000200100000206", ""), ("60081000", ""), ("0041", "")];
    let mut lines = vec![ASKED, foreign];
    lines.extend(noise);
    lines.push(("4F08100007", ""));
    assert_eq!(read(&lines), Some(Ok(vec![7])));
    assert_eq!(cause(read(&[ASKED, TEN, foreign])), TransferFailure::Interrupted { by: OTHER });
    let error = read(&[ASKED, TEN, foreign]).unwrap().unwrap_err();
    assert_eq!(error.to_string(), "object 1008h:00: another client has asked the device for 2000h:01");
}

#[test]
fn the_answer_to_a_repeated_first_frame_may_come_twice() {
    let lines = [ASKED, ("1000ms", "400810"), TEN, ("410810000A", ""), ("0041424344454647", "70"), ("19414243", "")];
    assert_eq!(read(&lines), Some(Ok(b"ABCDEFGABC"[..].into())));
    // Not once the transfer has gone on: the server may have begun anew.
    let lines = [ASKED, ("1000ms", "400810"), TEN, ("0041424344454647", "70"), ("410810000A", "8008100001000405")];
    assert_eq!(cause(read(&lines)), TransferFailure::Command { command: 0x41, done: 7 });
}

#[test]
fn a_server_without_blocks_gets_segments() {
    let head = ("", "2100200114");
    let refused = ("8000200101000405", head.1);
    assert_eq!(write(20, TransferMode::Block, &[BLOCK_WRITE, refused, ("60002001", "0055555555555555")]), None);
    // Without a checksum a lost step would go unnoticed.
    let unsafe_blocks = ("A00020017F", "8000200104000405 2100200114");
    assert_eq!(write(20, TransferMode::Block, &[BLOCK_WRITE, unsafe_blocks, ("60002001", "0055555555555555")]), None);
    // To read, a server may answer in segments without refusing.
    let lines = [BLOCKS, TEN, ("0041424344454647", "70"), ("19484950", "")];
    assert_eq!(play(SdoClient::upload(NAME, options(TransferMode::Block)), &lines), Some(Ok(b"ABCDEFGHIP"[..].into())));
    // The length is known and blocks are refused: segments are used, without a third attempt.
    let long = ("4108100050", "8008100000000008 A40810007F");
    assert_eq!(read(&[ASKED, long, ("8008100001000405", "400810"), ("4108100050", "60")]), None);
    assert_eq!(read(&[ASKED, long, ("C208100050", "8008100004000405 400810"), ("4108100050", "60")]), None);
}

#[test]
fn a_caller_may_give_up() {
    for (lines, abort) in [(0, ""), (1, "8008100000000008"), (2, "8008100000000008")] {
        let mut client = SdoClient::upload(NAME, TransferOptions::default());
        let mut out = Vec::new();
        if lines > 0 {
            client.start(Tick::ZERO, &mut out);
        }
        if lines > 1 {
            client.handle(Tick::ZERO, &raw("410810000A"), &mut out);
        }
        out.clear();
        let error = TransferError { object: NAME, cause: TransferFailure::Cancelled };
        assert_eq!(client.cancel(&mut out), TransferProgress::Done(Err(error)));
        assert_eq!(out.first().map_or(String::new(), text), abort);
        assert_eq!(client.cancel(&mut out), TransferProgress::Busy);
        assert_eq!(client.handle(Tick::ZERO, &raw("4F08100007"), &mut out), TransferProgress::Busy);
    }
}
