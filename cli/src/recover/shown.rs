//! A list as it is shown: the whole of it, or what is new in it since it was printed last.

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

    /// What is new in it, where `before` was printed: the steps in front of those that stay as they are, or the first one where
    /// only steps in front of it are gone.
    pub fn changes(&self, before: &ShownList) -> Vec<String> {
        let added = |now: &[String], was: &[String]| -> Vec<String> {
            now.iter().filter(|line| !was.contains(line)).cloned().collect()
        };
        let stays = self.steps.iter().rev().zip(before.steps.iter().rev()).take_while(|(now, was)| now == was).count();
        let is_shorter = stays == self.steps.len() && stays < before.steps.len();
        let shown = (self.steps.len() - stays).max(usize::from(is_shorter && stays > 0));
        let mut lines = added(&self.head, &before.head);
        lines.extend(self.numbered(shown));
        if shown > 0 && shown < self.steps.len() {
            lines.push(format!("       then as before, to step {}", self.steps.len()));
        }
        lines.extend(added(&self.tail, &before.tail));
        lines
    }
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
}
