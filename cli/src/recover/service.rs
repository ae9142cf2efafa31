//! What auto goes on without, below a list: resources out of service, and stations that are left out for another reason.

use linewright_cell::{Cell, Resource};

use super::typed_words;

/// The resources that are out of service, and what counts on them again: no mode does.
pub fn out_of_service(path: &str, down: &[String]) -> Vec<String> {
    let command = |words: &[&str]| {
        let words: Vec<String> = ["resource", path].iter().chain(words).map(|&word| word.to_owned()).collect();
        typed_words(&words)
    };
    if down.is_empty() {
        return Vec::new();
    }
    let why = format!("out of service: {}; since when and why: `{}`", down.join(", "), command(&[]));
    let up = down.iter().map(|name| format!("       when {name} can be counted on: `{}`", command(&[name, "up"])));
    std::iter::once(why).chain(up).collect()
}

/// The stations by their resources, `(resource, station)`: several resources may be one station's.
pub fn stations_of(cell: &Cell) -> Vec<(String, String)> {
    let of = |resource: &Resource| {
        let station = cell.controllers.get(resource.controller?.index())?;
        Some((resource.name.clone(), station.clone()))
    };
    cell.resources.iter().filter_map(of).collect()
}

/// The stations that are left out though no resource of theirs is `down`, and where that is explained; none where there is no such station.
pub fn left_out(path: &str, left_out: &[String], down: &[String], stations: &[(String, String)]) -> Option<String> {
    let is_explained = |name: &String| stations.iter().any(|(of, station)| station == name && down.contains(of));
    let names: Vec<&str> = left_out.iter().filter(|name| !is_explained(name)).map(String::as_str).collect();
    let [resource, why] = ["resource", "why"].map(|word| typed_words(&[word, path].map(str::to_owned)));
    (!names.is_empty())
        .then(|| format!("left out: {}; why, and what brings it back: `{resource}` and `{why}`", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Auto leaves out what an alarm by hand has taken out.
    #[test]
    fn a_resource_that_is_out_of_service_has_the_command_that_counts_on_it_again() {
        assert!(out_of_service("my cell", &[]).is_empty());
        let [why, up] = &out_of_service("my cell", &["M1".to_owned()])[..] else { panic!("one resource") };
        assert!(why.contains("out of service: M1") && why.contains("`linewright resource \"my cell\"`"), "{why}");
        assert!(up.contains("`linewright resource \"my cell\" M1 up`"), "{up}");
    }

    #[test]
    fn a_station_is_named_that_is_left_out_without_a_resource_out_of_service() {
        let [line, cell] = [
            include_str!("../../../launch-config/lines/workcell-c1/line.toml"),
            include_str!("../../../launch-config/lines/workcell-c1/cell.toml"),
        ];
        let line = linewright_line::parse("line.toml", line).expect("it is sound").line;
        let cell = linewright_cell::parse("cell.toml", cell, Some(&line)).expect("it is sound").cell;
        let stations = stations_of(&cell);
        let texts = |of: &[&str]| of.iter().map(|&of| of.to_owned()).collect::<Vec<_>>();
        let named =
            |stations_out: &[&str], down: &[&str]| left_out("c1", &texts(stations_out), &texts(down), &stations);
        assert_eq!(named(&[], &["M1"]), None);
        assert_eq!(named(&["m1"], &["M1"]), None, "the line above says so");
        let text = |names| {
            Some(format!(
                "left out: {names}; why, and what brings it back: `linewright resource c1` and `linewright why c1`"
            ))
        };
        assert_eq!(named(&["robot", "m1"], &["M1"]), text("robot"));
        // Without a state of the cell, or its description.
        assert_eq!(named(&["m1"], &[]), text("m1"));
        assert_eq!(left_out("c1", &texts(&["m1"]), &texts(&["M1"]), &[]), text("m1"));
    }
}
