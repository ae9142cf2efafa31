//! From the text of an interface to Rust text. What no interface here needs is refused with its line, not guessed.

mod describe;
mod read;
mod write;

pub use describe::TypeDescriptions;

/// The Rust types of one interface; `file` is its name with the ending for its kind. What ROS 2 calls its type descriptions are added.
pub fn rust(package: &str, file: &str, text: &str, types: &mut TypeDescriptions) -> Result<String, String> {
    let (name, kind) = file.split_once('.').unwrap_or((file, ""));
    let (doc, sections) = read::interface(text)?;
    let whole = write::InterfaceText { package, name, doc: &doc };
    let rust = match (kind, &sections[..]) {
        ("msg", [message]) => whole.message(message),
        ("srv", [request, response]) => whole.service(request, response),
        ("action", [goal, result, feedback]) => whole.action(goal, result, feedback),
        _ => return Err(format!("{} sections between lines of `---` do not make a `.{kind}` file", sections.len())),
    };
    types.add(&[package, kind, name], &sections);
    Ok(rust)
}
