//! Several files in one text, each behind a line `=== name`, for tests that edit texts.

use linewright_relations::{ParsedRelations, SourceText, parse};
use linewright_text::{Problem, Problems};

/// A cell with components, executions and interlocks of every kind.
pub const FIXTURE: &str = include_str!("fixture.txt");

/// The files of a text, each with the byte at which it begins.
pub fn split(text: &str) -> Vec<(usize, SourceText<'_>)> {
    let mut files = Vec::new();
    for part in text.split_inclusive("=== ").skip(1) {
        let part = part.strip_suffix("=== ").unwrap_or(part);
        let (name, text_of) = part.split_once('\n').unwrap_or((part, ""));
        files.push((
            text_of.as_ptr() as usize - text.as_ptr() as usize,
            SourceText { name: name.trim(), text: text_of },
        ));
    }
    files
}

/// Reads the files of a text.
pub fn read(text: &str) -> Result<ParsedRelations, Vec<Problems>> {
    let sources: Vec<SourceText<'_>> = split(text).into_iter().map(|(_, source)| source).collect();
    parse(&sources)
}

/// All problems of the files of a text, placed in the text; each message begins with its file.
pub fn problems(text: &str) -> Vec<Problem> {
    let found = match read(text) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems,
    };
    let files = split(text);
    let mut all = Vec::new();
    for of_file in found {
        let headline = of_file.to_string();
        let name = headline.split(':').next().unwrap_or_default();
        let begin = files.iter().find(|(_, source)| source.name == name).map_or(0, |(begin, _)| *begin);
        for mut problem in of_file.into_vec() {
            problem.span = problem.span.start + begin..problem.span.end + begin;
            problem.message = format!("{name}: {}", problem.message);
            all.push(problem);
        }
    }
    all
}
