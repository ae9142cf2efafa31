//! `linewright analyse` and `linewright nets`, as a user meets them: the built command, its output and its exit code.

use std::fmt::Write as _;

use serde_json::Value;

use crate::support::command::{Scratch, json, linewright, shipped, text};

/// What is found out about a file, as JSON.
fn analysed(file: &str, more: &[&str]) -> Value {
    let output = linewright(&[&["analyse", file, "--json"], more].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    json(&output)
}

/// Places with their tokens and transitions with what they take and give, as PNML.
fn pnml(places: &[(String, u32)], transitions: &[(String, Vec<String>, Vec<String>)]) -> String {
    let mut out = String::from("<pnml><net id=\"n\"><page id=\"g\">\n");
    for (id, tokens) in places {
        writeln!(out, "<place id=\"{id}\"><initialMarking><text>{tokens}</text></initialMarking></place>").unwrap();
    }
    for (id, takes, gives) in transitions {
        writeln!(out, "<transition id=\"{id}\"/>").unwrap();
        takes.iter().for_each(|p| writeln!(out, "<arc id=\"{p}-{id}\" source=\"{p}\" target=\"{id}\"/>").unwrap());
        gives.iter().for_each(|p| writeln!(out, "<arc id=\"{id}-{p}\" source=\"{id}\" target=\"{p}\"/>").unwrap());
    }
    out + "</page></net></pnml>\n"
}

/// A ring of stations, six operations each, that hand parts on through buffers of one place. With all buffers empty each
/// waits for the one before.
fn ring(stations: usize, is_dead: bool) -> String {
    let (mut places, mut transitions) = (Vec::new(), Vec::new());
    for i in 0..stations {
        let next = (i + 1) % stations;
        let is_full = !is_dead && i % 2 == 0;
        places.push((format!("f_{i}"), u32::from(is_full)));
        places.push((format!("e_{i}"), u32::from(!is_full)));
        for j in 0..6 {
            places.push((format!("o_{i}_{j}"), 0));
            places.push((format!("c_{i}_{j}"), u32::from(j == 5)));
            let mut start = (format!("s_{i}_{j}"), vec![format!("c_{i}_{}", (j + 5) % 6)], vec![format!("o_{i}_{j}")]);
            let mut done = (format!("d_{i}_{j}"), vec![format!("o_{i}_{j}")], vec![format!("c_{i}_{j}")]);
            if j == 2 {
                start.1.push(format!("f_{i}"));
                done.2.push(format!("e_{i}"));
            } else if j == 4 {
                start.1.push(format!("e_{next}"));
                done.2.push(format!("f_{next}"));
            }
            transitions.extend([start, done]);
        }
    }
    pnml(&places, &transitions)
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
        // How long it took does, and what the threads hold.
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
    assert_eq!(
        (&found["deadlock_free"], &found["live"], &found["deadlocks"]),
        (&false.into(), &false.into(), &1.into())
    );
    let shown = found["counterexamples"].as_array().unwrap();
    let deadlock = shown.iter().find(|play| play["shows"] == "deadlock").expect("a deadlock is shown");
    // Each station has done its first two operations, and waits for a part.
    assert_eq!(deadlock["fire"].as_array().unwrap().len(), 3 * 4, "{deadlock}");
    let marking = deadlock["marking"].as_array().unwrap();
    for place in ["c_0_1", "c_1_1", "c_2_1", "e_0", "e_1", "e_2"] {
        assert!(marking.contains(&serde_json::json!([place, 1])), "{place} in {marking:?}");
    }

    let table = linewright(&["analyse", &file]);
    assert_eq!(table.status.code(), Some(0), "{table:?}");
    let table = text(&table.stdout);
    assert!(table.contains("deadlock-free  no") && table.contains("fire    s_"), "{table}");
}

#[test]
fn what_is_too_large_is_undecided_and_not_guessed() {
    let scratch = Scratch::new();
    // Two stations that share a tool, so that no class of nets decides it.
    let words = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
    let shared = pnml(
        &["idle_a", "idle_b", "tool"]
            .map(|p| (p.to_owned(), 1))
            .into_iter()
            .chain(["a", "b"].map(|p| (p.to_owned(), 0)))
            .collect::<Vec<_>>(),
        &[
            ("take_a".into(), words(&["idle_a", "tool"]), words(&["a"])),
            ("take_b".into(), words(&["idle_b", "tool"]), words(&["b"])),
            ("give_a".into(), words(&["a"]), words(&["idle_a", "tool"])),
            ("give_b".into(), words(&["b"]), words(&["idle_b", "tool"])),
        ],
    );
    let file = scratch.file("shared.pnml", &shared);
    let found = analysed(&file, &["--states", "2"]);
    assert_eq!((&found["states"], &found["live"], &found["reversible"]), (&Value::Null, &Value::Null, &Value::Null));
    assert!(
        found["undecided"]
            .as_array()
            .unwrap()
            .iter()
            .any(|why| why.as_str().unwrap().contains("states, arcs: more than 2;")),
        "{found}"
    );
    let found = analysed(&file, &[]);
    assert_eq!((&found["states"], &found["live"], &found["reversible"]), (&3.into(), &true.into(), &true.into()));
    assert_eq!(found["decided_by"]["live"], "exploration");

    // A large ring is decided by structure, whatever the number of its states.
    let found = analysed(&scratch.file("ring.pnml", &ring(40, false)), &["--states", "1000"]);
    assert_eq!((&found["states"], &found["live"], &found["safe"]), (&Value::Null, &true.into(), &true.into()));
    assert_eq!((&found["deadlocks"], &found["bound"]), (&0.into(), &1.into()));
}

#[test]
fn an_unbounded_net_is_shown_to_grow() {
    let scratch = Scratch::new();
    let p = |name: &str| vec![name.to_owned()];
    let net = pnml(
        &[("idle".into(), 1), ("busy".into(), 0), ("parts".into(), 0)],
        &[
            ("start".into(), p("idle"), p("busy")),
            ("end".into(), p("busy"), vec!["idle".into(), "parts".into()]),
            ("never".into(), vec!["idle".into(), "busy".into()], vec![]),
        ],
    );
    let found = analysed(&scratch.file("net.pnml", &net), &[]);
    assert_eq!((&found["bounded"], &found["bound"], &found["states"]), (&false.into(), &Value::Null, &Value::Null));
    assert_eq!(found["unbounded_places"], serde_json::json!(["parts"]));
    assert_eq!(found["dead_transitions"], serde_json::json!(["never"]));
    let grows = found["counterexamples"].as_array().unwrap().iter().find(|play| play["shows"] == "unbounded").unwrap();
    assert_eq!((&grows["of"], grows["repeat"].as_array().unwrap().len()), (&"parts".into(), 2), "{grows}");
    assert!(found["undecided"].as_array().unwrap().iter().any(|why| why.as_str().unwrap().contains("unbounded")));
}

#[test]
fn what_does_not_hold_is_played() {
    let scratch = Scratch::new();
    let p = |names: &[&str]| names.iter().map(ToString::to_string).collect::<Vec<_>>();
    // Once `leave` has fired, nothing leads back, and `stay` is lost; the other two go on and on.
    let net = pnml(
        &[("a".into(), 2), ("b".into(), 0), ("c".into(), 0), ("d".into(), 1)],
        &[
            ("stay".into(), p(&["a", "d"]), p(&["a", "d"])),
            ("leave".into(), p(&["a", "d"]), p(&["b", "d"])),
            ("there".into(), p(&["b"]), p(&["c"])),
            ("back".into(), p(&["c"]), p(&["b"])),
        ],
    );
    let found = analysed(&scratch.file("net.pnml", &net), &[]);
    let not = ["safe", "live", "reversible"].map(|property| found[property] == false);
    assert_eq!((not, &found["deadlock_free"], &found["bound"]), ([true; 3], &true.into(), &2.into()), "{found}");
    assert_eq!(found["transitions_not_live"], serde_json::json!(["stay", "leave"]));
    let shown: Vec<_> =
        found["counterexamples"].as_array().unwrap().iter().map(|play| play["shows"].as_str().unwrap()).collect();
    assert_eq!(shown, ["unsafe", "not live", "not reversible"]);
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
    let problem = &json(&output)["problems"][0];
    assert_eq!((&problem["line"], &problem["column"]), (&3.into(), &32.into()));

    for args in [&["analyse", "no/such.pnml"][..], &["analyse", "no/such.pnml", "--json"]] {
        let output = linewright(args);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(text(&output.stdout).contains("no/such.pnml") || text(&output.stderr).contains("no/such.pnml"));
    }
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
    assert_eq!(graph["arcs"][0], serde_json::json!([0, 0, 1]));
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
    let output = linewright(&["nets", "no/such/line", "--out", &out]);
    assert!(output.status.code() == Some(1) && text(&output.stderr).contains("no/such/line"), "{output:?}");
}
