//! Operations that change the files of a log. A double lets them fail in tests.

use std::fmt::Debug;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::Arc;

/// Kind of an operation on a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiskOperation {
    Write,
    Sync,
    Truncate,
    Rename,
}

/// Decides which operations fail.
pub trait DiskFaults: Debug + Send + Sync {
    /// Called before each operation on the file or directory `of`.
    ///
    /// # Errors
    /// The operation fails with this. Of a write for which there is no room the first half is done.
    fn before(&self, operation: DiskOperation, of: &File) -> io::Result<()>;
}

/// A disk.
#[derive(Clone, Debug, Default)]
pub struct Disk(Option<Arc<dyn DiskFaults>>);

impl Disk {
    /// One where operations fail.
    pub fn with_faults(faults: Arc<dyn DiskFaults>) -> Self {
        Disk(Some(faults))
    }

    fn before(&self, operation: DiskOperation, of: &File) -> io::Result<()> {
        self.0.as_ref().map_or(Ok(()), |faults| faults.before(operation, of))
    }

    pub(super) fn write(&self, file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
        if let Err(error) = self.before(DiskOperation::Write, file) {
            if error.kind() == io::ErrorKind::StorageFull {
                file.write_all_at(&bytes[..bytes.len() / 2], at)?;
            }
            return Err(error);
        }
        file.write_all_at(bytes, at)
    }

    /// Of a file or a directory.
    pub(super) fn sync(&self, file: &File) -> io::Result<()> {
        self.before(DiskOperation::Sync, file)?;
        file.sync_all()
    }

    pub(super) fn sync_data(&self, file: &File) -> io::Result<()> {
        self.before(DiskOperation::Sync, file)?;
        file.sync_data()
    }

    pub(super) fn set_len(&self, file: &File, length: u64) -> io::Result<()> {
        self.before(DiskOperation::Truncate, file)?;
        file.set_len(length)
    }

    pub(super) fn rename(&self, file: &File, from: &Path, to: &Path) -> io::Result<()> {
        self.before(DiskOperation::Rename, file)?;
        std::fs::rename(from, to)
    }
}
