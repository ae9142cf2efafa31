//! A list as it is shown: the whole of it, or what is new in it since it was printed last.

/// In place of a plan that is looked for.
const SEARCHING: &str = "the way back is looked for";

/// A list in lines of text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShownList {
    /// What stands above the steps.
    pub head: Vec<String>,
    /// Each step without its number, with the lines below it.
    pub steps: Vec<Vec<String>>,
    /// What stands below the steps.
    pub tail: Vec<String>,
}

impl ShownList {
    /// All of it.
    pub fn lines(&self) -> Vec<String> {
        let steps = self.numbered(self.steps.len());
        self.head.iter().cloned().chain(steps).chain(self.tail.iter().cloned()).collect()
    }

    /// The first steps with their numbers.
    fn numbered(&self, count: usize) -> impl Iterator<Item = String> {
        self.steps.iter().take(count).enumerate().flat_map(|(at, step)| {
            let line = move |(nth, line): (usize, &String)| match nth {
                0 => format!("{:>5}. {line}", at + 1),
                _ => line.clone(),
            };
            step.iter().enumerate().map(line)
        })
    }

    /// Adds the line that a plan is searched for below the list. `steps` are shown until it is found.
    pub fn search(&mut self, steps: Vec<Vec<String>>) {
        self.steps = steps;
        self.tail.push(SEARCHING.to_owned());
    }

    /// Whether the last line is that a plan is searched for.
    pub fn is_searching(&self) -> bool {
        self.tail.last().is_some_and(|last| last == SEARCHING)
    }

    /// What is new in it, where `before` was printed: the steps in front of those that stay as they are, or the first one where
    /// only something in front of it is gone, or a line above or below the steps. While a plan is looked for no line counts as gone.
    pub fn changes(&self, before: &ShownList) -> Vec<String> {
        let stays = self.steps.iter().rev().zip(before.steps.iter().rev()).take_while(|(now, was)| now == was).count();
        let is_shorter = stays == self.steps.len() && stays < before.steps.len();
        let (head, above) = compared(&self.head, &before.head);
        let (tail, below) = compared(&self.tail, &before.tail);
        let is_less = is_shorter || (!self.is_searching() && (above || below));
        let shown = (self.steps.len() - stays).max(usize::from(is_less && stays > 0));
        let mut lines = head;
        lines.extend(self.numbered(shown));
        if shown > 0 && shown < self.steps.len() {
            lines.push(format!("       then as before, to step {}", self.steps.len()));
        }
        lines.extend(tail);
        // Without steps the mode stands for what is left.
        if lines.is_empty() && is_less {
            lines.extend(self.head.first().cloned());
        }
        lines
    }
}

/// The lines that are new, each as often as it is more often there than before; and whether one is gone.
fn compared(now: &[String], was: &[String]) -> (Vec<String>, bool) {
    let mut rest: Vec<&String> = was.iter().collect();
    let mut is_new = |line: &&String| match rest.iter().position(|was| was == line) {
        Some(at) => {
            rest.swap_remove(at);
            false
        }
        None => true,
    };
    let new = now.iter().filter(&mut is_new).cloned().collect();
    (new, !rest.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(mode: &str, steps: &[&str]) -> ShownList {
        let step = |text: &&str| vec![(*text).to_owned(), format!("       linewright {text}")];
        ShownList {
            head: vec![format!("mode: {mode}"), "cause: a switch".to_owned()],
            steps: steps.iter().map(step).collect(),
            tail: vec!["auto begins anew".to_owned()],
        }
    }

    #[test]
    fn a_list_is_printed_whole_once_and_then_what_is_new_in_it() {
        let first = list("stand-by", &["manual", "press", "auto"]);
        assert_eq!(first.changes(&ShownList::default()), first.lines());
        assert_eq!(first.changes(&first), [""; 0]);
        // A step was done: the next one, as it has to be done now.
        let second = list("manual", &["press", "auto"]);
        let next = ["mode: manual", "    1. press", "       linewright press", "       then as before, to step 2"];
        assert_eq!(second.changes(&first), next);
        // Something comes before what is left.
        let third = list("manual", &["wait", "press", "auto"]);
        let more = ["    1. wait", "       linewright wait", "       then as before, to step 3"];
        assert_eq!(third.changes(&second), more);
        assert_eq!(second.changes(&third)[0], "    1. press");
        // Another way: nothing of it stays.
        let other = list("manual", &["press", "home"]);
        assert_eq!(other.changes(&second).len(), 4);
        // A step in the middle is gone: what is in front of the rest is printed again.
        assert_eq!(list("manual", &["wait", "auto"]).changes(&third).len(), 3);
        assert_eq!(list("auto", &[]).changes(&second), ["mode: auto"]);
    }
    /// What stands there last is no more so: it is the first step again that is to be done.
    #[test]
    fn what_is_gone_above_or_below_the_steps_prints_the_first_one_again() {
        let before = list("manual", &["press", "auto"]);
        let again = ["    1. press", "       linewright press", "       then as before, to step 2"];
        let (mut without_cause, mut without_end) = (before.clone(), before.clone());
        without_cause.head.pop();
        without_end.tail.pop();
        assert_eq!(without_cause.changes(&before), again);
        assert_eq!(without_end.changes(&before), again);
        let (done, mut out) = (list("auto", &[]), list("auto", &[]));
        out.tail.push("out of service: M1".to_owned());
        assert_eq!(done.changes(&out), ["mode: auto"]);
    }

    #[test]
    fn a_search_that_finds_the_same_steps_prints_the_first_one_again() {
        let before = list("manual", &["press", "auto"]);
        let mut searching = ShownList { tail: Vec::new(), ..before.clone() };
        searching.search(before.steps.clone());
        assert!(searching.is_searching() && !before.is_searching());
        assert_eq!(searching.changes(&before), [SEARCHING], "what the plan said is not gone yet");
        let found = ShownList { tail: Vec::new(), ..before };
        assert_eq!(found.changes(&searching)[0], "    1. press");
    }

    #[test]
    fn a_press_that_is_done_twice_is_printed_twice() {
        let mut once = list("manual", &["press", "auto"]);
        once.head.push(" done  press".to_owned());
        let mut twice = once.clone();
        twice.head.push(" done  press".to_owned());
        assert_eq!(twice.changes(&once), [" done  press"]);
    }
}
