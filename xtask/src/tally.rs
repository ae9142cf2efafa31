//! Sum of the results of test programs.
//!
//! Tests run with `--show-output`, because a test that could not test anything prints that (a line that starts with
//! `SKIPPED`) and then passes, and the output of passing tests is otherwise thrown away. The rest of that output is
//! dropped here.

use crate::part::Stream;

/// Counts so far.
#[derive(Debug, Default)]
pub struct TestTally {
    /// Tests that passed.
    pub passed: usize,
    /// Tests that failed, and programs that ended badly without naming a test.
    pub failed: usize,
    /// Skipped tests with reasons, in the order of their messages.
    pub skipped: Vec<String>,
    /// Inside the list of what passing tests printed.
    in_successes: bool,
}

impl TestTally {
    /// Reads one line; true if a person should see it.
    pub fn read(&mut self, stream: Stream, line: &str) -> bool {
        if let Some(at) = line.find("SKIPPED") {
            self.skip(&line[at..]);
            return false;
        }
        if stream == Stream::Err {
            return true;
        }
        if let Some((passed, failed, ignored)) = result(line) {
            self.in_successes = false;
            self.passed += passed;
            self.failed += failed;
            if ignored > 0 {
                self.skip(&format!("SKIPPED {ignored} tests marked as ignored"));
            }
            return true;
        }
        match line {
            "successes:" => self.in_successes = true,
            "failures:" => self.in_successes = false,
            _ => {}
        }
        let is_passing = line.starts_with("test ") && line.ends_with(" ok");
        let is_noise = line.is_empty() || line.starts_with("running ") || is_passing;
        !self.in_successes && !is_noise
    }

    /// Adds what was counted elsewhere.
    pub fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        other.skipped.iter().for_each(|what| self.skip(what));
    }

    /// Notes a skipped test; once, however often it is reported.
    pub fn skip(&mut self, what: &str) {
        if !self.skipped.iter().any(|known| known == what) {
            self.skipped.push(what.to_owned());
        }
    }
}

/// Passed, failed and ignored of a line like `test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; …`.
fn result(line: &str) -> Option<(usize, usize, usize)> {
    let (_, counts) = line.split_once("test result: ")?;
    let count = |what: &str| {
        counts.split([';', '.']).find_map(|part| part.trim().strip_suffix(what)?.trim().parse::<usize>().ok())
    };
    Some((count("passed")?, count("failed")?, count("ignored")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(lines: &[&str]) -> (TestTally, Vec<String>) {
        let mut tally = TestTally::default();
        let shown = lines.iter().filter(|line| tally.read(Stream::Out, line)).map(ToString::to_string).collect();
        (tally, shown)
    }

    #[test]
    fn results_of_several_programs_add_up() {
        let (tally, shown) = read(&[
            "running 2 tests",
            "test a ... ok",
            "test b ... FAILED",
            "test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.08s",
            "test result: ok. 12 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s",
        ]);
        assert_eq!((tally.passed, tally.failed), (13, 1));
        assert_eq!(shown.len(), 3, "{shown:?}");
    }

    #[test]
    fn of_what_passing_tests_print_only_skips_are_kept() {
        let (tally, shown) = read(&[
            "test a ... ok",
            "successes:",
            "---- a stdout ----",
            "chatter",
            "SKIPPED vcan0: no such device",
            "successes:",
            "    a",
            "failures:",
            "---- b stdout ----",
            "thread 'b' panicked",
        ]);
        assert_eq!(tally.skipped, ["SKIPPED vcan0: no such device"]);
        assert_eq!(shown, ["failures:", "---- b stdout ----", "thread 'b' panicked"]);
    }

    #[test]
    fn ignored_tests_count_as_skipped() {
        let (tally, _) = read(&["test result: ok. 0 passed; 0 failed; 2 ignored; 0 measured; 0 filtered out"]);
        assert_eq!(tally.skipped, ["SKIPPED 2 tests marked as ignored"]);
    }
}
