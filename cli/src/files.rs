//! Files read up to a size: what is larger is not what it should be.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use miette::{IntoDiagnostic, WrapErr, miette};

/// A description may be this large; the parser refuses more, so no more is read.
const TEXT_BYTES_MAX: usize = 4 << 20;

/// The text of a description.
pub fn description(file: &Path) -> miette::Result<String> {
    text(file, TEXT_BYTES_MAX, "a description").map_err(|error| match file.try_exists() {
        Ok(false) => miette!(
            help = "expected a directory with line.toml or cell.toml, or a description file",
            "cannot read {}: there is no such file or directory",
            file.display()
        ),
        Ok(true) | Err(_) => error,
    })
}

/// A file's bytes, at most `most`; `what` it should be is for the error. No more is read: `/dev/zero` has no end.
pub fn bytes(path: &Path, most: usize, what: &str) -> miette::Result<Vec<u8>> {
    let name = path.display();
    let cannot = || format!("cannot read {name}");
    let file = File::open(path).into_diagnostic().wrap_err_with(cannot)?;
    let mut bytes = Vec::new();
    file.take(most as u64 + 1).read_to_end(&mut bytes).into_diagnostic().wrap_err_with(cannot)?;
    if bytes.len() > most {
        return Err(miette!("{name} is larger than {most} bytes, and {what} is not. Is this the right file?"));
    }
    Ok(bytes)
}

/// The same for a file of text.
pub fn text(path: &Path, most: usize, what: &str) -> miette::Result<String> {
    let bytes = bytes(path, most, what)?;
    String::from_utf8(bytes).into_diagnostic().wrap_err_with(|| format!("cannot read {}", path.display()))
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
        assert!(text(dir.path(), 3, "a text").is_err_and(|why| why.to_string().starts_with("cannot read")));
    }
}
