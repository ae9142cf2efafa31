//! Which of two whole-state messages is the newer one.
//!
//! A writer numbers its messages and marks them with a boot id that is new with every start of its
//! process. Sequence numbers alone would make a restarted writer (starting from 1) look old, and the
//! last words of its dead predecessor, still on their way, look new. So: within a boot the greater
//! sequence is newer; a boot id never seen replaces the current one; a boot id once replaced stays
//! replaced.

/// Boot ids remembered as replaced. A writer that restarts more often than this while one message is
/// on its way has other troubles.
const RETIRED_MAX: usize = 8;

/// What became of one message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Newest: the first of all, or the next one.
    Newest,
    /// Newest, but this many before it were never seen.
    NewestAfterGap {
        /// Sequence numbers skipped.
        missed: u64,
    },
    /// Newest, from a writer that has started anew.
    NewBoot,
    /// Seen before.
    Duplicate,
    /// Older than what was seen: overtaken on its way.
    Overtaken,
    /// From a writer that has been replaced since.
    OldBoot,
    /// Boot id 0, which no writer has.
    NoBoot,
}

impl Verdict {
    /// Whether the message is to be used.
    pub fn is_newest(self) -> bool {
        matches!(self, Self::Newest | Self::NewestAfterGap { .. } | Self::NewBoot)
    }
}

/// How often what happened, for diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Messages used.
    pub accepted: u64,
    /// Sequence numbers never seen.
    pub missed: u64,
    /// Messages seen twice.
    pub duplicates: u64,
    /// Messages overtaken on their way.
    pub overtaken: u64,
    /// Messages of a replaced boot, or of none.
    pub old_boots: u64,
    /// Restarts of the writer.
    pub restarts: u64,
}

/// The newest message of one writer, by (boot id, sequence).
#[derive(Debug, Clone, Default)]
pub struct NewestBySequence {
    current: Option<(u64, u64)>,
    retired: Vec<u64>,
    counts: Counts,
}

impl NewestBySequence {
    /// Nothing heard yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Judges the next message.
    pub fn offer(&mut self, boot_id: u64, sequence: u64) -> Verdict {
        let verdict = self.judge(boot_id, sequence);
        match verdict {
            Verdict::Newest => {}
            Verdict::NewestAfterGap { missed } => self.counts.missed = self.counts.missed.saturating_add(missed),
            Verdict::NewBoot => self.counts.restarts += 1,
            Verdict::Duplicate => self.counts.duplicates += 1,
            Verdict::Overtaken => self.counts.overtaken += 1,
            Verdict::OldBoot | Verdict::NoBoot => self.counts.old_boots += 1,
        }
        if verdict.is_newest() {
            self.counts.accepted += 1;
            self.replace(boot_id, sequence);
        }
        verdict
    }

    /// Boot id and sequence of the newest message.
    pub fn current(&self) -> Option<(u64, u64)> {
        self.current
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    fn judge(&self, boot_id: u64, sequence: u64) -> Verdict {
        if boot_id == 0 {
            return Verdict::NoBoot;
        }
        match self.current {
            None => Verdict::Newest,
            Some((boot, _)) if boot != boot_id && self.retired.contains(&boot_id) => Verdict::OldBoot,
            Some((boot, _)) if boot != boot_id => Verdict::NewBoot,
            Some((_, seen)) if sequence == seen => Verdict::Duplicate,
            Some((_, seen)) if sequence < seen => Verdict::Overtaken,
            Some((_, seen)) if sequence - seen == 1 => Verdict::Newest,
            Some((_, seen)) => Verdict::NewestAfterGap { missed: sequence - seen - 1 },
        }
    }

    fn replace(&mut self, boot_id: u64, sequence: u64) {
        if let Some((boot, _)) = self.current
            && boot != boot_id
        {
            if self.retired.len() == RETIRED_MAX {
                self.retired.remove(0);
            }
            self.retired.push(boot);
        }
        self.current = Some((boot_id, sequence));
    }
}

#[cfg(test)]
mod tests {
    use super::Verdict::*;
    use super::*;

    #[test]
    fn one_writer_and_its_restarts() {
        let mut newest = NewestBySequence::new();
        for (boot, sequence, verdict) in [
            (0, 1, NoBoot),
            (7, 5, Newest),
            (7, 6, Newest),
            (7, 6, Duplicate),
            (7, 9, NewestAfterGap { missed: 2 }),
            (7, 8, Overtaken),
            (8, 1, NewBoot),
            (7, 10, OldBoot),
            (8, 2, Newest),
            (9, 1, NewBoot),
            (8, 3, OldBoot),
            (7, 11, OldBoot),
            (9, u64::MAX, NewestAfterGap { missed: u64::MAX - 2 }),
        ] {
            assert_eq!(newest.offer(boot, sequence), verdict, "boot {boot} sequence {sequence}");
        }
        assert_eq!(newest.current(), Some((9, u64::MAX)));
        assert_eq!(
            newest.counts(),
            Counts { accepted: 7, missed: u64::MAX, duplicates: 1, overtaken: 1, old_boots: 4, restarts: 2 }
        );
    }

    #[test]
    fn only_the_last_boots_are_remembered() {
        let mut newest = NewestBySequence::new();
        for boot in 1..=10 {
            newest.offer(boot, 1);
        }
        assert_eq!(newest.offer(2, 2), OldBoot);
        assert_eq!(newest.offer(1, 2), NewBoot, "forgotten after eight more");
    }
}
