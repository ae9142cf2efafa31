//! The server against a client that a test plays by hand: every way a transfer ends, and what is left of it.

use super::*;

/// A server with a read-only name of ten bytes and an object of two bytes.
struct ServerBench {
    server: SdoServer,
    store: ByteDictionary,
    now: Tick,
}

impl ServerBench {
    fn new() -> Self {
        let mut store = ByteDictionary::with(NAME, b"ABCDEFGHIJ");
        store.objects.insert(OTHER, vec![1, 2]);
        ServerBench { server: SdoServer::new(20), store, now: Tick::from_millis(1) }
    }

    /// Its answer to a request.
    fn ask(&mut self, request: &str) -> String {
        let mut out = Vec::new();
        self.server.handle(self.now, &raw(request), &mut self.store, &mut out);
        out.iter().map(text).collect::<Vec<_>>().join(" ")
    }

    fn pass(&mut self, millis: u64) -> String {
        self.now = after(self.now, millis);
        let mut out = Vec::new();
        self.server.poll(self.now, &mut out);
        out.iter().map(text).collect::<Vec<_>>().join(" ")
    }

    /// Requests with their answers; at the end nothing is under way and nothing was written.
    fn all(lines: &[(&str, &str)]) {
        let mut bench = ServerBench::new();
        for (request, answer) in lines {
            let given = match request.strip_suffix("ms") {
                Some(millis) => bench.pass(millis.parse().unwrap()),
                None => bench.ask(request),
            };
            assert_eq!(given, *answer, "to {request} in {lines:?}");
        }
        assert_eq!(bench.server.next_deadline(), None, "{lines:?}");
        assert_eq!((bench.store.writes, &bench.store.objects[&OTHER]), (0, &vec![1, 2]), "{lines:?}");
    }
}

#[test]
fn what_the_dictionary_refuses_is_refused_at_once() {
    ServerBench::all(&[("400110", "8001100000000206")]);
    ServerBench::all(&[("A40110007F", "8001100000000206")]);
    ServerBench::all(&[("2F08100001", "8008100002000106")]);
    ServerBench::all(&[("210810000A", "8008100002000106")]);
    ServerBench::all(&[("C60810000A", "8008100002000106")]);
}

#[test]
fn commands_that_do_not_exist_or_do_not_fit() {
    ServerBench::all(&[("E0", "8000000001000405")]);
    for stray in ["00", "60", "A1", "A2017F", "A3", "C1"] {
        ServerBench::all(&[(stray, "8000000001000405")]);
        ServerBench::all(&[
            ("400810", "410810000A"),
            (stray, if stray == "60" { "0041424344454647" } else { "8008100001000405" }),
            ("80", ""),
        ]);
    }
    ServerBench::all(&[("81", "8000000001000405")]);
}

#[test]
fn toggles_that_do_not_alternate() {
    ServerBench::all(&[("400810", "410810000A"), ("70", "8008100000000305")]);
    ServerBench::all(&[("400810", "410810000A"), ("60", "0041424344454647"), ("60", "8008100000000305")]);
    ServerBench::all(&[("210020010A", "60002001"), ("10", "8000200100000305")]);
    ServerBench::all(&[("210020010A", "60002001"), ("00", "20"), ("00", "8000200100000305")]);
}

#[test]
fn lengths_that_are_not_those_announced() {
    let head = ("210020010A", "60002001");
    ServerBench::all(&[head, ("00", "20"), ("1B", "8000200113000706")]);
    ServerBench::all(&[head, ("00", "20"), ("17", "8000200112000706")]);
    let blocks = ("C60020010A", "A40020017F");
    ServerBench::all(&[blocks, ("01", ""), ("82", "A2027F"), ("D5", "8000200113000706")]);
    ServerBench::all(&[blocks, ("01", ""), ("02", ""), ("03", "8000200112000706")]);
}

#[test]
fn more_than_there_is_room_for() {
    ServerBench::all(&[("2100200115", "8000200105000405")]);
    ServerBench::all(&[("C600200115", "8000200105000405")]);
    ServerBench::all(&[("20002001", "60002001"), ("00", "20"), ("10", "30"), ("00", "8000200105000405")]);
    ServerBench::all(&[("C4002001", "A40020017F"), ("01", ""), ("02", ""), ("03", ""), ("04", "8000200105000405")]);
    ServerBench::all(&[
        ("C4002001", "A40020017F"),
        ("01", ""),
        ("02", ""),
        ("83", "A2037F"),
        ("C1", "8000200105000405"),
    ]);
}

#[test]
fn blocks_out_of_sequence_or_with_a_wrong_checksum() {
    let head = ("C60020010A", "A40020017F");
    ServerBench::all(&[head, ("00", "8000200103000405")]);
    ServerBench::all(&[head, ("01", ""), ("82", "A2027F"), ("D13412", "8000200104000405")]);
    let none = ("FF", "A2007F");
    ServerBench::all(&[head, none, none, none, ("FF", "8000200103000405")]);
    let (offer, start) = (("A40810007F", "C60810000A"), ("A3", "0141424344454647 8248494A"));
    ServerBench::all(&[offer, start, ("A2037F", "8008100003000405")]);
    ServerBench::all(&[offer, start, ("A201", "8008100002000405")]);
    ServerBench::all(&[("A4081000", "8008100002000405")]);
    ServerBench::all(&[("A408100080", "8008100002000405")]);
    let again = ("A2007F", start.1);
    ServerBench::all(&[offer, start, again, again, again, ("A2007F", "8008100003000405")]);
}

#[test]
fn a_client_that_gives_up_is_forgotten() {
    let abort = ("80", "");
    ServerBench::all(&[("400810", "410810000A"), abort]);
    ServerBench::all(&[("210020010A", "60002001"), ("00", "20"), abort]);
    ServerBench::all(&[("C60020010A", "A40020017F"), ("01", ""), abort]);
    ServerBench::all(&[("C60020010A", "A40020017F"), ("01", ""), ("82", "A2027F"), abort]);
    ServerBench::all(&[("A40810007F", "C60810000A"), abort]);
    ServerBench::all(&[("A40810007F", "C60810000A"), ("A3", "0141424344454647 8248494A"), abort]);
}

#[test]
fn a_client_that_is_gone_is_given_up() {
    let (read, write) = (("3000ms", "8008100000000405"), ("3000ms", "8000200100000405"));
    ServerBench::all(&[("400810", "410810000A"), ("2999ms", ""), ("1ms", read.1)]);
    ServerBench::all(&[("210020010A", "60002001"), ("00", "20"), write]);
    ServerBench::all(&[("A40810007F", "C60810000A"), read]);
    ServerBench::all(&[("A40810007F", "C60810000A"), ("A3", "0141424344454647 8248494A"), read]);
    ServerBench::all(&[("A40810007F", "C60810000A"), ("A3", "0141424344454647 8248494A"), ("A2027F", "D1F586"), read]);
    let stall = ("250ms", "A2007F");
    let last = ("250ms", "8000200100000405");
    ServerBench::all(&[("C60020010A", "A40020017F"), ("01", ""), ("250ms", "A2017F"), stall, stall, stall, last]);
}

#[test]
fn a_new_transfer_replaces_the_old_one() {
    let mut bench = ServerBench::new();
    bench.ask("210020010A");
    bench.ask("00");
    assert_eq!(bench.ask("400810"), "410810000A");
    assert_eq!(bench.ask("60"), "0041424344454647");
    assert_eq!(bench.ask("70"), "1948494A");
    assert_eq!(bench.ask("10"), "8000000001000405");
    assert_eq!(bench.store.writes, 0);
}

#[test]
fn the_frame_that_began_a_block_may_come_again() {
    let mut bench = ServerBench::new();
    assert_eq!(bench.ask("C600200102"), "A40020017F");
    assert_eq!(bench.ask("C600200102"), "A40020017F");
    assert_eq!(bench.ask("810708"), "A2017F");
    let [low, high] = block::crc(&[7, 8]).to_le_bytes();
    assert_eq!(bench.ask(&format!("D5{low:02X}{high:02X}")), "A1");
    assert_eq!(bench.store.objects[&OTHER], [7, 8]);
}

#[test]
fn short_objects_are_not_sent_in_blocks_where_the_client_says_so() {
    let mut bench = ServerBench::new();
    assert_eq!(bench.ask("A40810007F0A"), "410810000A");
    assert_eq!(bench.ask("A40810007F09"), "C60810000A");
    assert_eq!(bench.ask("A40020017F09"), "4B0020010102");
}

#[test]
fn a_client_without_checksum_is_served() {
    let mut bench = ServerBench::new();
    assert_eq!(bench.ask("C200200102"), "A00020017F");
    assert_eq!(bench.ask("810708"), "A2017F");
    assert_eq!(bench.ask("D5"), "A1");
    assert_eq!(bench.store.objects[&OTHER], [7, 8]);
    assert_eq!(bench.ask("A00810007F"), "C20810000A");
    assert_eq!(bench.ask("A3"), "0141424344454647 8248494A");
    assert_eq!(bench.ask("A2027F"), "D1");
    assert_eq!(bench.ask("A1"), "");
    assert_eq!(bench.server.next_deadline(), None);
}
