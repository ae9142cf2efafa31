//! Progress on standard error while a check takes long.

use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use linewright_proof::explore::SearchProgress;

/// On a terminal nothing is printed of shorter checks, and then so often.
const ON_TERMINAL: (Duration, Duration) = (Duration::from_secs(2), Duration::from_secs(10));
/// The same in a file or a pipe.
const ELSEWHERE: (Duration, Duration) = (Duration::from_secs(10), Duration::from_secs(60));

/// What is looked at, and how far that is.
#[derive(Debug, Default)]
pub struct CheckProgress {
    /// The present search.
    pub search: SearchProgress,
    stage: Mutex<CheckStage>,
}

#[derive(Debug, Default)]
struct CheckStage {
    /// The place of the part that is looked at, from 1, and the number of parts; of a part in smaller parts, theirs behind it.
    parts: Vec<(usize, usize)>,
    what: String,
}

impl CheckProgress {
    fn stage(&self) -> MutexGuard<'_, CheckStage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is looked at from now on.
    pub fn shows(&self, what: &str) {
        what.clone_into(&mut self.stage().what);
        self.search.begin(0);
    }

    /// Looks at one of several parts, by its place from 1 and their number.
    pub fn in_part<T>(&self, nth: usize, number: usize, look: impl FnOnce() -> T) -> T {
        self.stage().parts.push((nth, number));
        let found = look();
        self.stage().parts.pop();
        found
    }

    /// What is looked at and how far that is, in a line.
    fn text(&self, elapsed: Duration) -> String {
        let stage = self.stage();
        let mut parts: Vec<String> =
            stage.parts.iter().map(|(nth, number)| format!("part {nth} of {number}")).collect();
        // A part that is looked at in smaller ones is named first.
        parts.iter_mut().skip(1).for_each(|part| part.insert_str(0, "smaller "));
        // The number of the part stands in place of the word.
        let what = if parts.is_empty() { &stage.what } else { stage.what.trim_start_matches("part: ") };
        let (states, states_max) = self.search.states();
        let mut text = format!("visiting states for {} s", elapsed.as_secs());
        for shown in [parts.join(", "), what.to_owned()].into_iter().filter(|shown| !shown.is_empty()) {
            text += &format!(": {shown}");
        }
        if self.search.is_again() {
            text += "; once more from the start, for the nearest violation";
        }
        if states_max > 0 {
            text += &format!("; {states} looked at, the limit is {states_max}");
        }
        text
    }
}

/// Prints the progress of a check on standard error until it is dropped; into a file or a pipe less often.
pub struct SlowCheck {
    pub progress: Arc<CheckProgress>,
    _ends: Sender<()>,
}

impl SlowCheck {
    pub fn begin() -> Self {
        let (first, again) = if std::io::stderr().is_terminal() { ON_TERMINAL } else { ELSEWHERE };
        let (ends, ended) = channel::<()>();
        let progress = Arc::new(CheckProgress::default());
        let shown = Arc::clone(&progress);
        std::thread::spawn(move || {
            let began = Instant::now();
            // The check has ended when the other end is gone.
            let goes_on = |wait| ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout);
            if !goes_on(first) {
                return;
            }
            crate::out::complain!(
                "visiting every state that the controllers can reach, which may take minutes; --structure leaves it out"
            );
            loop {
                crate::out::complain!("{}", shown.text(began.elapsed()));
                if !goes_on(again) {
                    return;
                }
            }
        });
        SlowCheck { progress, _ends: ends }
    }
}

#[cfg(test)]
mod tests {
    use linewright_proof::explore::{LineExploration, SearchLimits, explore_watched};

    use super::*;

    #[test]
    fn it_names_the_part_and_how_far_its_search_is() {
        let progress = CheckProgress::default();
        assert_eq!(progress.text(Duration::from_secs(22)), "visiting states for 22 s");
        let text = linewright_line::TransferLine::default().text();
        let line = linewright_line::parse("line.toml", &text).expect("the shipped line is sound").line;
        progress.shows("part: transfer, clamp_1");
        let limits = SearchLimits { states: 500, ..SearchLimits::default() };
        explore_watched(&LineExploration::new(&line), limits, &progress.search).expect("it can be explored");
        let shown = progress.in_part(2, 5, || progress.in_part(1, 3, || progress.text(Duration::from_secs(70))));
        let (what, states) = shown.split_once("; ").expect("it has figures");
        assert_eq!(what, "visiting states for 70 s: part 2 of 5, smaller part 1 of 3: transfer, clamp_1");
        let looked_at: usize = states.split(' ').next().and_then(|figure| figure.parse().ok()).expect("a number");
        assert!((1..=500).contains(&looked_at), "{states}");
        assert!(states.ends_with(" looked at, the limit is 500"), "{states}");
        progress.shows("the next search");
        assert_eq!(progress.text(Duration::ZERO), "visiting states for 0 s: the next search");
    }
}
