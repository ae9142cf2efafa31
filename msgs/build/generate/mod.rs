//! From the text of an interface to Rust text. What no interface here needs is refused with its line, not guessed.

mod read;
mod write;

/// The Rust types of one interface; `file` is its name with the ending for its kind.
pub fn rust(package: &str, file: &str, text: &str) -> Result<String, String> {
    let (name, kind) = file.split_once('.').unwrap_or((file, ""));
    let (doc, sections) = read::interface(text)?;
    let whole = write::InterfaceText { package, name, doc: &doc };
    match (kind, &sections[..]) {
        ("msg", [message]) => Ok(whole.message(message)),
        ("srv", [request, response]) => Ok(whole.service(request, response)),
        ("action", [goal, result, feedback]) => Ok(whole.action(goal, result, feedback)),
        _ => Err(format!("{} sections between lines of `---` do not make a `.{kind}` file", sections.len())),
    }
}
