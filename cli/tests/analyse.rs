//! `linewright analyse` and `linewright nets`, as a user meets them: the built command, its output and its exit code.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::support::command::{Scratch, json as printed, linewright, shipped, text};

/// Report on a file, as JSON.
fn analysed(file: &str, more: &[&str]) -> Value {
    let output = linewright(&[&["analyse", file, "--json"], more].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    printed(&output)
}

/// A net in short as PNML: places with their tokens, then transitions with what they take and give, as in
/// `a:2 b | t: a a > b, u: b >`.
fn pnml(short: &str) -> String {
    let (places, transitions) = short.split_once('|').expect("places and transitions");
    let mut out = String::from("<pnml><net id=\"n\"><page id=\"g\">\n");
    for place in places.split_whitespace() {
        let (id, tokens) = place.split_once(':').unwrap_or((place, "0"));
        writeln!(out, "<place id=\"{id}\"><initialMarking><text>{tokens}</text></initialMarking></place>").unwrap();
    }
    for transition in transitions.split(',') {
        let (id, arcs) = transition.trim().split_once(':').expect("a name");
        let (takes, gives) = arcs.split_once('>').expect("takes and gives");
        writeln!(out, "<transition id=\"{id}\"/>").unwrap();
        for p in takes.split_whitespace() {
            writeln!(out, "<arc id=\"{p}-{id}\" source=\"{p}\" target=\"{id}\"/>").unwrap();
        }
        for p in gives.split_whitespace() {
            writeln!(out, "<arc id=\"{id}-{p}\" source=\"{id}\" target=\"{p}\"/>").unwrap();
        }
    }
    out + "</page></net></pnml>\n"
}

/// A ring of stations, six operations each, that hand parts on through buffers of one place. With all buffers empty each
/// waits for the one before.
fn ring(stations: usize, is_dead: bool) -> String {
    let (mut places, mut transitions) = (String::new(), Vec::new());
    for i in 0..stations {
        let next = (i + 1) % stations;
        let full = u32::from(!is_dead && i % 2 == 0);
        write!(places, "f_{i}:{full} e_{i}:{} ", 1 - full).unwrap();
        for j in 0..6 {
            write!(places, "o_{i}_{j} c_{i}_{j}:{} ", u32::from(j == 5)).unwrap();
            let (takes, gives) = match j {
                2 => (format!("f_{i}"), format!("e_{i}")),
                4 => (format!("e_{next}"), format!("f_{next}")),
                _ => Default::default(),
            };
            transitions.push(format!("s_{i}_{j}: c_{i}_{} {takes} > o_{i}_{j}", (j + 5) % 6));
            transitions.push(format!("d_{i}_{j}: o_{i}_{j} > c_{i}_{j} {gives}"));
        }
    }
    pnml(&format!("{places}|{}", transitions.join(",")))
}

/// The numbers are those of an independent program that plays the nets out on bit masks.
#[test]
fn a_ring_of_stations_is_live_safe_and_reversible_with_so_many_states() {
    let scratch = Scratch::new();
    for (stations, states, arcs) in [(3, 3444, 9588), (4, 46256, 169_456)] {
        let found = analysed(&scratch.file("ring.pnml", &ring(stations, false)), &[]);
        let number = |key: &str| found[key].as_u64();
        assert_eq!((number("places"), number("transitions")), (Some(14 * stations as u64), Some(12 * stations as u64)));
        assert_eq!((number("states"), number("arcs"), number("deadlocks")), (Some(states), Some(arcs), Some(0)));
        assert_eq!(number("bound"), Some(1));
        for property in ["bounded", "safe", "deadlock_free", "live", "reversible"] {
            assert_eq!(found[property], true, "{property}");
            assert_eq!(found["decided_by"][property], "structure", "{property}");
        }
        // One token of control for each station, and one in each buffer; going once round is the only repetition.
        assert!(number("p_semiflows") >= Some(2 * stations as u64), "{found}");
        assert_eq!(number("t_semiflows"), Some(1));
        assert!(found["class"].as_array().unwrap().contains(&"marked graph".into()));
        assert!(found["seconds"].as_f64().unwrap() > 0.0 && number("bytes") > Some(0));
        assert_eq!(found["undecided"].as_array().unwrap().len(), 0, "{found}");
        assert_eq!(found["counterexamples"].as_array().unwrap().len(), 0);
    }
}

#[test]
fn the_answers_do_not_depend_on_the_threads() {
    let scratch = Scratch::new();
    let file = scratch.file("ring.pnml", &ring(3, false));
    let answers = |threads| {
        let mut found = analysed(&file, &["--threads", threads]);
        // Its time varies, and the bytes of the threads.
        let found = found.as_object_mut().unwrap();
        found.remove("seconds");
        found.remove("bytes");
        found.clone()
    };
    assert_eq!(answers("1"), answers("2"));
}

#[test]
fn a_ring_in_which_all_wait_is_found_with_the_way_into_it() {
    let scratch = Scratch::new();
    let file = scratch.file("dead.pnml", &ring(3, true));
    let found = analysed(&file, &[]);
    let shown = found["counterexamples"].as_array().unwrap();
    let deadlock = shown.iter().find(|play| play["shows"] == "deadlock").expect("a deadlock is shown");
    // Each station has done its first two operations, and waits for a part.
    assert_eq!(deadlock["fire"].as_array().unwrap().len(), 3 * 4, "{deadlock}");
    let marking = deadlock["marking"].as_array().unwrap();
    for place in ["c_0_1", "c_1_1", "c_2_1", "e_0", "e_1", "e_2"] {
        assert!(marking.contains(&json!([place, 1])), "{place} in {marking:?}");
    }
    let table = linewright(&["analyse", &file]);
    assert_eq!(table.status.code(), Some(0), "{table:?}");
    let table = text(&table.stdout);
    assert!(table.contains("deadlock-free  no") && table.contains("fire    s_"), "{table}");
}

/// Properties that hold are found, others have a counterexample, and those of a net too large are undecided and not
/// guessed.
#[test]
fn facts_counterexamples_and_what_stays_undecided() {
    // Two stations that share a tool, so that no class of nets decides it.
    let shared = "idle_a:1 idle_b:1 tool:1 a b | take_a: idle_a tool > a, take_b: idle_b tool > b, \
                  give_a: a > idle_a tool, give_b: b > idle_b tool";
    // Once `leave` has fired, nothing leads back, and `stay` is lost; the other two go on and on.
    let leaves = "a:2 b c d:1 | stay: a d > a d, leave: a d > b d, there: b > c, back: c > b";
    let grows = "idle:1 busy parts | start: idle > busy, end: busy > idle parts, never: idle busy >";
    let (too_large, unknown) = ("states, arcs: more than 2;", Value::Null);
    // The net, options, facts, paths, and open questions.
    let cases = [
        (
            pnml(shared),
            &["--states", "2"][..],
            json!({"states": unknown, "live": unknown, "reversible": unknown}),
            &[][..],
            too_large,
        ),
        (pnml(shared), &[], json!({"states": 3, "live": true, "reversible": true}), &[], ""),
        // A large ring is decided by structure, whatever the number of its states.
        (
            ring(40, false),
            &["--states", "1000"],
            json!({"states": unknown, "live": true, "safe": true, "deadlocks": 0, "bound": 1}),
            &[],
            "states, arcs: more than 1000;",
        ),
        (ring(3, true), &[], json!({"deadlock_free": false, "live": false, "deadlocks": 1}), &["deadlock"], ""),
        (
            pnml(grows),
            &[],
            json!({"bounded": false, "bound": unknown, "states": unknown, "unbounded_places": ["parts"],
                "dead_transitions": ["never"]}),
            &["unbounded"],
            "unbounded",
        ),
        (
            pnml(leaves),
            &[],
            json!({"safe": false, "live": false, "reversible": false, "deadlock_free": true, "bound": 2,
                "transitions_not_live": ["stay", "leave"]}),
            &["unsafe", "not live", "not reversible"],
            "",
        ),
    ];
    let scratch = Scratch::new();
    for (net, options, facts, played, undecided) in cases {
        let found = analysed(&scratch.file("net.pnml", &net), options);
        for (key, expected) in facts.as_object().unwrap() {
            assert_eq!(&found[key], expected, "{key}: {found}");
        }
        let shown: Vec<_> = found["counterexamples"].as_array().unwrap().iter().map(|play| &play["shows"]).collect();
        assert_eq!(shown, played, "{found}");
        let reasons = found["undecided"].to_string();
        assert!(if undecided.is_empty() { reasons == "[]" } else { reasons.contains(undecided) }, "{reasons}");
    }
    let found = analysed(&scratch.file("net.pnml", &pnml(shared)), &[]);
    assert_eq!(found["decided_by"]["live"], "exploration");
    let found = analysed(&scratch.file("net.pnml", &pnml(grows)), &[]);
    let grows = found["counterexamples"].as_array().unwrap().iter().find(|play| play["shows"] == "unbounded").unwrap();
    assert_eq!((&grows["of"], grows["repeat"].as_array().unwrap().len()), (&"parts".into(), 2), "{grows}");
}

#[test]
fn a_broken_file_is_explained_and_not_analysed() {
    let scratch = Scratch::new();
    let file = scratch.file(
        "broken.pnml",
        "<pnml><net id=\"n\">\n<place id=\"p\"/>\n<arc id=\"a\" source=\"p\" target=\"q\"/>\n</net></pnml>",
    );
    let output = linewright(&["analyse", &file]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let told = text(&output.stderr);
    assert!(told.contains("broken.pnml:3:32") && told.contains("leads to `q`, which is no node"), "{told}");
    assert!(output.stdout.is_empty());

    let output = linewright(&["analyse", &file, "--json"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let problem = &printed(&output)["problems"][0];
    assert_eq!((&problem["line"], &problem["column"]), (&3.into(), &32.into()));

    for args in [&["analyse", "no/such.pnml"][..], &["analyse", "no/such.pnml", "--json"]] {
        let output = linewright(args);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(text(&output.stdout).contains("no/such.pnml") || text(&output.stderr).contains("no/such.pnml"));
    }
    let directory = linewright(&["analyse", &scratch.path(".")]);
    assert!(text(&directory.stderr).contains("`linewright nets "), "{directory:?}");
}

#[test]
fn one_of_several_nets_is_chosen_by_id() {
    let scratch = Scratch::new();
    let file = scratch.file(
        "nets.pnml",
        "<pnml><net id=\"a\"><place id=\"p\"/></net><net id=\"b\"><transition id=\"t\"/></net></pnml>",
    );
    let output = linewright(&["analyse", &file]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("--net ID"), "{output:?}");
    assert_eq!(analysed(&file, &["--net", "b"])["transitions"], 1);
}

#[test]
fn the_graph_the_drawing_and_the_certificates_are_written() {
    let scratch = Scratch::new();
    let file = scratch.file("ring.pnml", &ring(1, true));
    let found = analysed(&file, &[]);
    let (states, arcs) = (found["states"].as_u64().unwrap() as usize, found["arcs"].as_u64().unwrap() as usize);
    let paths = ["graph.dot", "graph.json", "graph.aut", "net.dot", "net.cert"].map(|name| scratch.path(name));
    for graph in &paths[..3] {
        analysed(&file, &["--graph", graph, "--dot", &paths[3], "--certificate", &paths[4]]);
    }
    let drawn = scratch.read("graph.dot");
    assert_eq!(drawn.matches("];\n").count(), 1 + states + arcs, "the node style, the states, the arcs");
    assert!(
        drawn.contains("s0 [label=\"e_0, c_0_5\", penwidth=2];") && drawn.contains("s0 -> s1 [label=\"s_0_0\"];"),
        "{drawn}"
    );
    let graph: Value = serde_json::from_str(&scratch.read("graph.json")).unwrap();
    assert_eq!(graph["states"].as_array().unwrap().len(), states);
    assert_eq!(graph["arcs"].as_array().unwrap().len(), arcs);
    assert_eq!(graph["arcs"][0], json!([0, 0, 1]));
    let lines = scratch.read("graph.aut");
    assert_eq!(lines.lines().next(), Some(format!("des (0, {arcs}, {states})").as_str()));
    assert_eq!((lines.lines().nth(1), lines.lines().count()), (Some("(0, \"s_0_0\", 1)"), 1 + arcs));
    assert!(scratch.read("net.dot").contains("label=\"c_0_5\\n1\""));
    assert!(scratch.read("net.cert").starts_with("claim: "));

    let output = linewright(&["analyse", &file, "--graph", &scratch.path("graph.txt")]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains(".dot, .json or .aut"), "{output:?}");
    assert!(output.stdout.is_empty(), "what is asked wrongly is said before the search: {output:?}");
    let output = linewright(&["analyse", &file, "--states", "3", "--graph", &paths[0]]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("no graph is written"), "{output:?}");
    let output = linewright(&["analyse", &file, "--memory", "0", "--graph", &paths[0]]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("no graph is written"), "{output:?}");
}

#[test]
fn the_nets_of_the_shipped_line_are_written_and_hold() {
    let scratch = Scratch::new();
    let line = shipped();
    let (line, out) = (line.to_str().unwrap(), scratch.path("out"));
    let output = linewright(&["nets", line, "--out", &out]);
    assert!(output.status.success() && text(&output.stdout).contains("transfer.pnml: 60 places"), "{output:?}");
    for (name, places) in [("transfer", 60), ("clamp_1", 12), ("mill_1", 27), ("mode-decision", 6)] {
        let found = analysed(&format!("{out}/{name}.pnml"), &[]);
        assert_eq!(found["places"], places, "{name}");
        for property in ["live", "safe", "reversible", "deadlock_free"] {
            assert_eq!(found[property], true, "{name}: {property}: {found}");
        }
        assert_eq!(found["undecided"].as_array().unwrap().len(), 0, "{name}: {found}");
    }
    let output = linewright(&["nets", line, "--out", &out, "--format", "dot"]);
    assert!(output.status.success(), "{output:?}");
    assert!(scratch.read("out/clamp_1.dot").starts_with("digraph \"clamp_1\""));
    let output = linewright(&["nets", line, "--out", &out, "--format", "svg"]);
    assert!(output.status.success(), "{output:?}");
    let drawn = scratch.read("out/clamp_1.svg");
    assert_eq!(
        (drawn.matches("<circle").count(), drawn.matches("<rect").count()),
        (12 + 1, 22 + 1),
        "a token, a ground"
    );
    assert!(drawn.contains("<title>advance clamp C^N</title>") && drawn.ends_with("</svg>\n"), "{drawn}");
    let output = linewright(&["nets", "no/such/line", "--out", &out]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("no/such/line"), "{output:?}");
}
