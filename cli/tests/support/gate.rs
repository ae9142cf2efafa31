//! A disk that takes its time, or stands still, for files of some names: a library that is preloaded into processes.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A directory with one file for each name whose writes are delayed, and the preloaded library that reads it.
pub struct Gates {
    directory: PathBuf,
    library: PathBuf,
}

impl Gates {
    /// Builds the library in a new directory.
    pub fn build(directory: &Path) -> Self {
        fs::create_dir_all(directory).expect("a directory");
        let library = directory.join("gate.so");
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/support/gate.c");
        let built = Command::new("cc").args(["-O1", "-shared", "-fPIC", "-o"]).arg(&library).arg(source).status();
        assert!(built.expect("a C compiler, which links Rust programs too").success());
        Gates { directory: directory.to_owned(), library }
    }

    /// Environment variables for processes.
    pub fn environment(&self) -> [(&'static str, &Path); 2] {
        [("LD_PRELOAD", &self.library), ("LINEWRIGHT_GATE", &self.directory)]
    }

    /// Writes to files of this name wait until the gate is dropped.
    pub fn close(&self, name: &str) -> Gate {
        let closed = self.directory.join(name);
        drop(File::create(&closed).expect("a file"));
        Gate { closed }
    }

    /// Writes to files of this name take so long until the gate is dropped.
    pub fn delay(&self, name: &str, milliseconds: u32) -> Gate {
        let closed = self.directory.join(name);
        fs::write(&closed, milliseconds.to_string()).expect("a file");
        Gate { closed }
    }
}

/// One name that has to wait.
pub struct Gate {
    closed: PathBuf,
}

impl Gate {
    /// Whether a write has begun to wait.
    pub fn is_reached(&self) -> bool {
        let mut waits = self.closed.clone().into_os_string();
        waits.push(".waits");
        PathBuf::from(waits).exists()
    }
}

impl Drop for Gate {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.closed);
    }
}
