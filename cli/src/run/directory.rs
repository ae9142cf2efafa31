//! The directory of a run's journals and logs.

use std::path::{Path, PathBuf};

use miette::{IntoDiagnostic, WrapErr};

/// The directory that was given, or a temporary one.
pub struct RunDirectory {
    pub dir: PathBuf,
    temporary: bool,
}

impl RunDirectory {
    pub fn new(given: Option<&Path>) -> miette::Result<Self> {
        let dir = match given {
            Some(dir) => dir.to_owned(),
            None => std::env::temp_dir().join(format!("linewright-run-{}", std::process::id())),
        };
        std::fs::create_dir_all(&dir).into_diagnostic().wrap_err_with(|| format!("cannot use {}", dir.display()))?;
        Ok(RunDirectory { dir, temporary: given.is_none() })
    }

    /// Removes a temporary directory, unless the run failed: its logs are wanted then.
    pub fn end(self, ok: bool) {
        if self.temporary && ok {
            let _ = std::fs::remove_dir_all(&self.dir);
        }
    }
}
