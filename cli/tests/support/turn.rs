//! Tests that may run at once: two lines of processes, which mostly wait; or commands that end by themselves, which
//! compute; or one test alone.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// As many lines at once: more would make each other late.
const RIGS_MAX: u32 = 2;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Rig,
    Command,
    Alone,
}

struct Running {
    rigs: u32,
    commands: u32,
    is_alone: bool,
}

static RUNNING: Mutex<Running> = Mutex::new(Running { rigs: 0, commands: 0, is_alone: false });
static CHANGED: Condvar = Condvar::new();

/// Held while a test runs what it is for.
pub struct Turn(Kind);

/// A line of processes; not beside commands.
pub fn rig() -> Turn {
    Turn::take(Kind::Rig)
}

/// A command; not beside a line.
pub fn beside_no_rig() -> Turn {
    Turn::take(Kind::Command)
}

/// Nothing else.
pub fn alone() -> Turn {
    Turn::take(Kind::Alone)
}

fn running() -> MutexGuard<'static, Running> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Turn {
    fn take(kind: Kind) -> Self {
        let waits = |now: &mut Running| match kind {
            Kind::Rig => now.is_alone || now.commands > 0 || now.rigs >= RIGS_MAX,
            Kind::Command => now.is_alone || now.rigs > 0,
            Kind::Alone => now.is_alone || now.rigs > 0 || now.commands > 0,
        };
        let mut now = CHANGED.wait_while(running(), waits).unwrap_or_else(PoisonError::into_inner);
        match kind {
            Kind::Rig => now.rigs += 1,
            Kind::Command => now.commands += 1,
            Kind::Alone => now.is_alone = true,
        }
        Turn(kind)
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        let mut now = running();
        match self.0 {
            Kind::Rig => now.rigs -= 1,
            Kind::Command => now.commands -= 1,
            Kind::Alone => now.is_alone = false,
        }
        CHANGED.notify_all();
    }
}
