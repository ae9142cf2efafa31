//! Describing a line: what `new` writes, station types and I/O lists, as a user meets them.

use std::path::Path;

use crate::support::command::{Scratch, is_quiet, json, linewright, linewright_in, shipped, text};

fn new(kind: &str, options: &[&str]) -> std::process::Output {
    linewright(&[&["new", kind], options].concat())
}

#[test]
fn what_is_new_is_right_and_can_be_simulated() {
    for (kind, simulate) in [
        ("transfer-line", &["--cycles", "2"][..]),
        ("rotary-table", &["--cycles", "2"]),
        ("cell", &["--parts", "bowl=3"]),
        ("empty-line", &["--cycles", "2"]),
        ("empty-cell", &["--parts", "A=2"]),
    ] {
        let scratch = Scratch::new();
        let dir = scratch.path("d");
        let made = new(kind, &["--name", "of_mine", "--dir", &dir]);
        assert!(made.status.success(), "{made:?}");
        let said = text(&made.stdout);
        for next in ["check", "simulate", "run"] {
            assert!(said.contains(&format!("linewright {next} {dir}")), "{said}");
        }
        // The transfer line is the shipped one by another name, which is checked as that.
        if kind != "transfer-line" {
            let checked = linewright(&["check", &dir]);
            assert!(checked.status.success() && is_quiet(&checked), "{kind}: {checked:?}");
            assert!(text(&checked.stdout).contains("✓ of_mine"), "{checked:?}");
        }
        let simulated = linewright(&[&["simulate", &dir], simulate].concat());
        assert!(simulated.status.success() && simulated.stderr.is_empty(), "{kind}: {simulated:?}");
    }
}

#[test]
fn a_name_is_one_that_the_reader_takes_and_the_directory_is_called_like_it() {
    for wrong in ["Of-mine", "2nd", "a__b", ""] {
        let output = new("cell", &["--name", wrong]);
        assert_eq!(output.status.code(), Some(2), "{wrong}");
        assert!(
            text(&output.stderr).contains("cannot be the name of a line or cell: lower-case letters"),
            "{output:?}"
        );
    }
    let scratch = Scratch::new();
    let run = |words: &[&str]| linewright_in(&scratch.path("."), words);
    let said = run(&["new", "cell", "laundry"]);
    assert!(text(&said.stdout).contains("next:  linewright check laundry\n"), "{said:?}");
    assert!(scratch.read("laundry/cell.toml").contains("\nname = \"laundry\"  # the ROS namespace"));
    assert!(scratch.read("laundry/line.toml").contains("\nname = \"laundry\"  # the ROS namespace"));
    // One file that is there is enough for none to be written.
    std::fs::remove_file(scratch.path("laundry/cell.toml")).expect("it was there");
    let again = run(&["new", "cell", "--name", "laundry"]);
    assert!(!again.status.success() && text(&again.stderr).contains("laundry/line.toml is there already"), "{again:?}");
    assert!(!Path::new(&scratch.path("laundry/cell.toml")).exists());
    assert!(run(&["new", "cell", "--name", "laundry", "--force"]).status.success());
    assert!(run(&["new", "rotary-table"]).status.success() && Path::new(&scratch.path("rotary-table")).exists());
}

#[test]
fn what_is_printed_with_stations_written_out_is_the_same_line() {
    let scratch = Scratch::new();
    assert!(new("rotary-table", &["--dir", &scratch.path("types")]).status.success());
    let output = linewright(&["expand", &scratch.path("types")]);
    assert!(output.status.success(), "{output:?}");
    let expanded = scratch.file("expanded.toml", text(&output.stdout));
    assert!(!text(&output.stdout).contains("station_type"));
    let checked = |path: &str| json(&linewright(&["check", path, "--json", "--structure"]));
    assert_eq!(checked(&expanded)["stations"], checked(&scratch.path("types"))["stations"]);
    let wrong = scratch.file("wrong.toml", "[[station_type]]\nname = 3\n");
    let refused = linewright(&["expand", &wrong]);
    assert!(!refused.status.success() && refused.stdout.is_empty(), "{refused:?}");
}

#[test]
fn an_io_list_goes_out_and_comes_back() {
    let scratch = Scratch::new();
    let line = shipped();
    let before = std::fs::read_to_string(line.join("line.toml")).expect("the shipped line");
    let copy = scratch.file("line.toml", &before);
    let exported = linewright(&["io", "export", &copy]);
    assert!(exported.status.success(), "{exported:?}");
    let list = text(&exported.stdout).to_owned();
    assert!(list.starts_with("name,address,device,station,comment\n"), "{list}");

    let same = scratch.file("same.csv", &list);
    let output = linewright(&["io", "import", &copy, &same]);
    assert!(output.status.success() && text(&output.stdout).ends_with("nothing is different\n"), "{output:?}");
    assert_eq!(scratch.read("line.toml"), before);

    // As a spreadsheet has it, with a comment, and two switches exchanged.
    let changed = list
        .replace("LS_open,%IX0.0,clamp 1 io,clamp_1,", "LS_open,%IX0.1,clamp 1 io,clamp_1,\"open, -B1\"")
        .replace("LS_closed,%IX0.1,", "LS_closed,%IX0.0,");
    let changed = changed.lines().map(|row| if row.contains('"') { row.to_owned() } else { row.replace(',', ";") });
    let changed =
        changed.map(|row| row.replacen("LS_open,%IX0.1,clamp 1 io,clamp_1,", "LS_open;%IX0.1;clamp 1 io;clamp_1;", 1));
    let changed = scratch.file("changed.csv", &format!("\u{feff}{}\r\n", changed.collect::<Vec<_>>().join("\r\n")));
    let shown = linewright(&["io", "import", &copy, &changed, "--dry-run"]);
    assert!(
        shown.status.success() && text(&shown.stdout).contains("3 would be different; nothing was written"),
        "{shown:?}"
    );
    assert_eq!(scratch.read("line.toml"), before);
    let output = linewright(&["io", "import", &copy, &changed]);
    assert!(output.status.success(), "{output:?}");
    assert!(text(&output.stdout).contains("clamp_1: LS_open: clamp 1 io %IX0.0 → clamp 1 io %IX0.1"), "{output:?}");
    let after = scratch.read("line.toml");
    assert!(
        after.contains("[\"LS_closed\", \"LS_open\", \"low_pressure\"") && after.contains("LS_open = \"open, -B1\"")
    );
    assert_eq!(after.lines().count(), before.lines().count() + 3);
    assert!(linewright(&["check", &copy, "--structure"]).status.success());

    // Anything wrong: nothing is written.
    let wrong =
        scratch.file("wrong.csv", "name,address,device\nLS_open,%IX0.0,clamp 1 io\nLS_closed,%IX0.9,clamp 1 io\n");
    let refused = linewright(&["io", "import", &copy, &wrong]);
    assert!(!refused.status.success() && refused.stdout.is_empty(), "{refused:?}");
    assert!(text(&refused.stderr).contains("wrong.csv:3: column address: `%IX0.9` is no address"), "{refused:?}");
    let gone = scratch.file("gone.csv", "name,address,device\n,%IX0.0,clamp 1 io\n");
    let refused = linewright(&["io", "import", &copy, &gone]);
    assert!(!refused.status.success(), "{refused:?}");
    assert!(text(&refused.stderr).contains("nothing was written"), "{refused:?}");
    assert_eq!(scratch.read("line.toml"), after);
}

/// A table of tags from a controller's tool: its own words, its own encoding, and addresses counted through it.
#[test]
fn a_controllers_tag_table_is_taken_with_where_devices_begin() {
    let scratch = Scratch::new();
    let before = std::fs::read_to_string(shipped().join("line.toml")).expect("the shipped line");
    let copy = scratch.file("line.toml", &before);
    let table = "Name;Path;Data Type;Logical Address;Comment\r\nLS_closed;Tags;Bool;%I12.0;r\u{fc}ckseitig\r\n\
         LS_open;Tags;Bool;E 12.1;\r\nlow_pressure;Tags;Bool;%I12.2;\r\ncycles;Tags;Int;%MW20;\r\n";
    let bytes: Vec<u8> = table.chars().map(|letter| u8::try_from(letter).expect("Latin")).collect();
    let list = scratch.path("tags.csv");
    std::fs::write(&list, bytes).expect("written");
    let refused = linewright(&["io", "import", &copy, &list]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("--begin"), "{refused:?}");
    let output = linewright(&["io", "import", &copy, &list, "--begin", "clamp 1 io=%I12"]);
    assert!(output.status.success(), "{output:?}");
    assert!(text(&output.stderr).contains("read as Windows-1252"), "{output:?}");
    let shown = text(&output.stdout);
    assert!(shown.starts_with("1 row is left out: it is of no digital input or output"), "{shown}");
    assert!(shown.contains("LS_closed: clamp 1 io %IX0.1 → clamp 1 io %IX0.0"), "{shown}");
    let after = scratch.read("line.toml");
    assert!(after.contains("[\"LS_closed\", \"LS_open\", \"low_pressure\"") && after.contains("rückseitig"));
    let twice = linewright(&["io", "import", &copy, &list, "--begin", "clamp 1 io"]);
    assert!(!twice.status.success() && text(&twice.stderr).contains("drill io=%I4,%Q2"), "{twice:?}");
}

/// What is missing is named with its path; of a line, what has no sense there is named.
#[test]
fn what_is_asked_of_nothing_or_of_a_line_is_refused_with_the_reason() {
    let scratch = Scratch::new();
    let nowhere = scratch.path("nowhere");
    for words in
        [&["why", &nowhere][..], &["order", &nowhere], &["answer", &nowhere], &["resource", &nowhere, "M1", "up"]]
    {
        let refused = linewright(words);
        assert!(!refused.status.success() && refused.stdout.is_empty(), "{refused:?}");
        assert!(
            text(&refused.stderr).contains("cannot read") && text(&refused.stderr).contains("nowhere"),
            "{refused:?}"
        );
    }
    let line = shipped().display().to_string();
    let refused = linewright(&["order", &line]);
    assert!(text(&refused.stderr).contains("a line has no orders, alarms or resources"), "{refused:?}");
    let unknown = linewright(&["why", &line, "clamp_9"]);
    assert!(
        text(&unknown.stderr).contains("no station 'clamp_9'; the line has transfer, clamp_1, mill_1"),
        "{unknown:?}"
    );
    for words in [&["part", "7"][..], &["7"]] {
        let part = linewright(&[&["why", &line], words].concat());
        assert!(text(&part.stderr).contains(&format!("'{}' is a part, and ", words.join(" "))), "{part:?}");
    }
    let kind = new("line", &["--name", "x"]);
    assert!(text(&kind.stderr).contains("linewright new transfer-line my_line"), "{kind:?}");
}

#[test]
fn a_cell_is_recognised_whatever_its_file_is_called() {
    let scratch = Scratch::new();
    let dir = shipped().join("../assembly-cell");
    let read = |name: &str| std::fs::read_to_string(dir.join(name)).expect("the shipped cell");
    let other = scratch.file("of_mine.toml", &read("cell.toml"));
    let alone = linewright(&["check", &other, "--json"]);
    assert!(alone.status.success(), "{alone:?}");
    assert!(json(&alone)["cell"].is_object(), "{alone:?}");
    let needs = linewright(&["run", &other, "--parts", "1=1"]);
    assert!(!needs.status.success(), "{needs:?}");
    assert!(text(&needs.stderr).contains("describes a flexible cell"), "{needs:?}");
    let simulated = linewright(&["simulate", &other, "--parts", "1=1"]);
    assert!(simulated.status.success(), "{simulated:?}");

    // The other way round, and a cell where a line is looked for.
    let swapped = Scratch::new();
    swapped.file("cell.toml", &read("line.toml"));
    let output = linewright(&["check", &swapped.path("cell.toml")]);
    assert!(text(&output.stderr).contains("describes a line, not a flexible cell"), "{output:?}");
    let swapped = Scratch::new();
    swapped.file("line.toml", &read("cell.toml"));
    let output = linewright(&["simulate", &swapped.path("")]);
    assert!(text(&output.stderr).contains("describes a flexible cell, not a line"), "{output:?}");
}

#[test]
fn a_cell_is_not_run_without_a_state_directory_by_mistake() {
    let path = shipped().with_file_name("assembly-cell");
    let cell = path.to_str().expect("a path in text");
    let output = linewright(&["coordinator", cell]);
    assert!(!output.status.success());
    let said = text(&output.stderr);
    assert!(said.contains("has no state directory") && said.contains("--forget"), "{said}");
    let both = linewright(&["coordinator", cell, "--forget", "--state-dir", "d"]);
    assert_eq!(both.status.code(), Some(2), "{both:?}");
}
