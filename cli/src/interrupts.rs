//! Ctrl-C, received whenever it comes.
//!
//! `tokio::signal::ctrl_c()` in the arm of a loop's `select!` listens only while it is awaited: a Ctrl-C that comes
//! while the loop handles something else is lost, and on a busy line that is often. One listener for the whole loop
//! keeps it.

use miette::IntoDiagnostic;
use tokio::signal::unix::{Signal, SignalKind, signal};

/// Every Ctrl-C from now on.
pub struct Interrupts(Signal);

impl Interrupts {
    /// Begins to listen; from here on Ctrl-C does not end the process by itself.
    pub fn listen() -> miette::Result<Self> {
        signal(SignalKind::interrupt()).into_diagnostic().map(Interrupts)
    }

    /// The next one, at once if it has come meanwhile. Cancel safe.
    pub async fn next(&mut self) {
        if self.0.recv().await.is_none() {
            // The runtime receives no signals any more; callers also wait for other things.
            std::future::pending::<()>().await;
        }
    }
}
