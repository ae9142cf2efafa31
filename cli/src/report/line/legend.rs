//! What the figures of a line's report are, a line of text for each.

/// Name as the report prints it, and what it is.
const LEGEND: [(&str, &str); 22] = [
    ("produced", "in auto, motion enabled, nothing wrong"),
    ("stopped", "not producing, by the causes listed"),
    ("start-up", "from the coordinator's beginning until the line produces, 30 s at most; no stop"),
    ("not recorded", "no coordinator ran, or its notes could not be written; no stop"),
    ("APT", "actual production time: produced"),
    ("ADET", "actual unit delay time: stopped, without the operator's stops"),
    ("AUBT", "actual unit busy time: APT + ADET"),
    ("PBT", "planned busy time: --planned-busy"),
    ("PQ, GQ", "produced quantity: cycles ended; good quantity: PQ less --rejected"),
    ("PRI", "planned run time per item: a cycle by the description alone"),
    ("utilization efficiency", "the share of production in busy time"),
    ("availability", "the share of production in planned busy time"),
    (
        EFFECTIVENESS,
        "planned time of the cycles beside the time produced; a cycle that was faster counts as it ran, so 100 % at most",
    ),
    ("quality ratio", "the share of good cycles in all"),
    ("OEE index", "availability x effectiveness x quality ratio"),
    ("busy", "of a station: an operation in motion, while the line produced"),
    ("waited", "standing in auto for a reason, the last one to go away; below, each reason with its time"),
    ("other", "neither, as between two motions"),
    ("motions", "operations done or taken back"),
    ("stopped (station)", "motions that ended on their way"),
    ("faults", "faults of the station in the span"),
    ("90 %, 99 %", "so many of the cycles took no longer; by nearest rank"),
];

const EFFECTIVENESS: &str = "effectiveness";

/// What a figure is, by its name.
pub fn meaning(name: &str) -> Option<&'static str> {
    LEGEND.iter().find(|(known, _)| *known == name).map(|(_, meaning)| *meaning)
}

/// The legend, a line for each.
pub fn text() -> String {
    let width = LEGEND.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines = LEGEND.iter().map(|(name, meaning)| format!("  {name:width$}  {meaning}\n"));
    std::iter::once("\nlegend\n".to_owned()).chain(lines).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A new figure without a line here fails.
    #[test]
    fn each_figure_has_a_line() {
        let none = || Err(String::new());
        let figures = linewright_history::line::LineFigures {
            planned_run_time: None,
            produced: 0,
            production: Default::default(),
            delay: Default::default(),
            utilization_efficiency: none(),
            availability: none(),
            effectiveness: none(),
            quality_ratio: none(),
            oee: none(),
        };
        for (name, formula, _) in super::super::figures(&figures) {
            assert!(meaning(name).is_some(), "{name}");
            for term in formula.split(|c: char| !c.is_ascii_uppercase()).filter(|term| term.len() > 1) {
                let is_known =
                    term == "QR" || LEGEND.iter().any(|(names, _)| names.split(", ").any(|name| name == term));
                assert!(is_known, "{term} of {name}");
            }
        }
        assert!(meaning(EFFECTIVENESS).is_some_and(|meaning| meaning.contains("100 % at most")), "it is capped");
        assert_eq!(text().lines().count(), LEGEND.len() + 2);
    }
}
