//! Files read up to a size: what is larger is not what it should be.

use std::fs::File;
use std::io::{self, ErrorKind, Read as _};
use std::path::{Component, Path, PathBuf};

use miette::miette;
use rustix::fs::Mode;

/// A description may be this large; the parser refuses more, so no more is read.
const TEXT_BYTES_MAX: usize = 4 << 20;

/// The text of a description.
pub fn description(file: &Path) -> miette::Result<String> {
    text(file, TEXT_BYTES_MAX, "a description").map_err(|error| match file.try_exists() {
        // A directory with the name of a description: one of that name was looked for in it.
        Ok(false) if file.parent().is_some_and(|dir| dir.file_name() == file.file_name() && dir.is_dir()) => {
            is_directory(file.parent().unwrap_or(file))
        }
        Ok(false) => miette!(
            help = "expected a directory with line.toml or cell.toml, or a description file",
            "cannot read {}: there is no such file or directory",
            file.display()
        ),
        Ok(true) | Err(_) => error,
    })
}

fn is_directory(path: &Path) -> miette::Report {
    miette!(help = "give the file, or the directory that it is in", "{} is a directory, not a file", path.display())
}

/// A file that cannot be read, with what to do.
fn cannot_read(path: &Path, error: &io::Error) -> miette::Report {
    let name = path.display();
    match error.kind() {
        ErrorKind::IsADirectory => is_directory(path),
        ErrorKind::PermissionDenied => miette!(
            help = "give its user the right to read it, and to enter the directories above it",
            "cannot read {name}: {error}"
        ),
        _ => miette!("cannot read {name}: {error}"),
    }
}

/// The path of a file (EDS, DCF, DBC) that a description in the directory `dir` names: in that directory or below it.
///
/// A description from elsewhere could otherwise name any file that its user may read, and have lines of that file printed as errors.
/// A symbolic link in the directory may lead elsewhere: it was made by a person with write access to the directory.
///
/// # Errors
/// When the name leads out of the directory.
pub fn beside(dir: &Path, file: &str) -> miette::Result<PathBuf> {
    let is_inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    if Path::new(file).components().all(is_inside) {
        return Ok(dir.join(file));
    }
    Err(miette!(
        help = "copy it beside the description, or make a symbolic link to it there",
        "`{file}` is not in the directory of the description"
    ))
}

/// Files that this process makes from now on, and directories, are readable by their owner alone: journals, logs and databases
/// show what is produced, and when. What is there already keeps its rights.
pub fn keep_from_others() {
    rustix::process::umask(Mode::RWXG | Mode::RWXO);
}

/// A directory that cannot be written to, with what to do.
pub fn cannot_use(dir: &Path, error: &io::Error) -> miette::Report {
    let name = dir.display();
    match error.kind() {
        _ if dir.is_file() => miette!(
            help = "--state-dir is a directory; it is made where it is not there",
            "cannot use {name}: it is a file"
        ),
        ErrorKind::PermissionDenied => miette!(
            help = "give its user the right to write there, or another --state-dir",
            "cannot use {name}: {error}"
        ),
        ErrorKind::StorageFull => {
            miette!(help = "make room there, or give another --state-dir", "cannot use {name}: {error}")
        }
        _ => miette!(help = "give another --state-dir", "cannot use {name}: {error}"),
    }
}

/// A file's bytes, at most `most`; `what` it should be is for the error. No more is read: `/dev/zero` has no end.
pub fn bytes(path: &Path, most: usize, what: &str) -> miette::Result<Vec<u8>> {
    let name = path.display();
    let cannot = |error: io::Error| cannot_read(path, &error);
    let file = File::open(path).map_err(cannot)?;
    let mut bytes = Vec::new();
    file.take(most as u64 + 1).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() > most {
        return Err(miette!("{name} is larger than {most} bytes, and {what} is not. Is this the right file?"));
    }
    Ok(bytes)
}

/// The same for a file of text.
pub fn text(path: &Path, most: usize, what: &str) -> miette::Result<String> {
    let bytes = bytes(path, most, what)?;
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        miette!(
            help = "save it as UTF-8 in the editor",
            "cannot read {}: line {line} has bytes that are not UTF-8",
            path.display()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_file_without_an_end_no_more_is_read_than_it_may_have() {
        let why = bytes(Path::new("/dev/zero"), 1000, "a description").expect_err("it is longer");
        assert!(why.to_string().starts_with("/dev/zero is larger than 1000 bytes"), "{why}");
    }

    #[test]
    fn where_there_is_no_description_it_is_named_what_is_looked_for() {
        let why = description(Path::new("dail")).expect_err("there is none");
        assert_eq!(why.to_string(), "cannot read dail: there is no such file or directory");
        assert!(why.help().is_some_and(|help| help.to_string().contains("line.toml or cell.toml")));
    }

    #[test]
    fn a_file_may_have_as_much_as_is_allowed() {
        let dir = tempfile::tempdir().expect("a directory");
        let file = dir.path().join("file");
        std::fs::write(&file, "1234").expect("written");
        assert_eq!(text(&file, 4, "a text").expect("read"), "1234");
        assert!(text(&file, 3, "a text").is_err());
        let why = text(dir.path(), 3, "a text").expect_err("it is no file");
        assert_eq!(why.to_string(), format!("{} is a directory, not a file", dir.path().display()));
    }

    #[test]
    fn what_cannot_be_read_or_used_is_named_with_what_to_do() {
        let dir = tempfile::tempdir().expect("a directory");
        let file = dir.path().join("line.toml");
        std::fs::write(&file, b"name = \"x\"\ntitle = \"\xFF\"\n").expect("written");
        let why = description(&file).expect_err("it is not UTF-8");
        assert!(why.to_string().ends_with("line.toml: line 2 has bytes that are not UTF-8"), "{why}");
        assert!(why.help().is_some_and(|help| help.to_string().contains("save it as UTF-8")));
        let why = cannot_use(&file, &io::Error::from(ErrorKind::AlreadyExists));
        assert!(why.to_string().ends_with("line.toml: it is a file") && why.help().is_some(), "{why}");
        let why = cannot_read(&file, &io::Error::from(ErrorKind::PermissionDenied));
        assert!(why.help().is_some_and(|help| help.to_string().contains("right to read")), "{why}");
        // A directory with the name of a description.
        std::fs::create_dir(dir.path().join("cell.toml")).expect("made");
        let why = description(&dir.path().join("cell.toml/cell.toml")).expect_err("there is none");
        assert!(why.to_string().ends_with("cell.toml is a directory, not a file"), "{why}");
    }
}
