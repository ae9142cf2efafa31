//! Progress on standard error while a check takes long.

use std::io::IsTerminal;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Of shorter checks nothing is printed.
const FIRST: Duration = Duration::from_secs(2);
const AGAIN: Duration = Duration::from_secs(20);

/// Prints the time that a check has taken so far on standard error until it is dropped; into a file or a pipe less often.
pub struct SlowCheck {
    _ends: Sender<()>,
}

impl SlowCheck {
    pub fn begin() -> Self {
        let (first, again) = if std::io::stderr().is_terminal() { (FIRST, AGAIN) } else { (3 * AGAIN, 3 * AGAIN) };
        let (ends, ended) = channel::<()>();
        std::thread::spawn(move || {
            let began = Instant::now();
            let mut wait = first;
            // The check has ended when the other end is gone.
            while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                crate::out::complain!("{}", text(began.elapsed()));
                wait = again;
            }
        });
        SlowCheck { _ends: ends }
    }
}

fn text(elapsed: Duration) -> String {
    match elapsed < AGAIN {
        true => "visiting every state that the controllers can reach; of a line of three stations this may take a minute or more; \
                 --structure leaves it out"
            .to_owned(),
        false => format!("still visiting states, for {} s", elapsed.as_secs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_does_comes_first_and_then_how_long_it_has() {
        assert!(text(FIRST).contains("may take a minute or more; --structure leaves it out"));
        assert_eq!(text(FIRST + AGAIN), "still visiting states, for 22 s");
    }
}
