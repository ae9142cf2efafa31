//! One section being read: its keys as texts and numbers, and problems that name section and key.

use linewright_diagnostics::{Problem, Report, shown};

use crate::ini::{IniKey, SectionRef};
use crate::number;

/// Severity of a value that is not understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// A device might be sent something else.
    Error,
    /// It is information, or a check that is then not made.
    Warning,
}

/// A section, and the report for its errors.
pub(crate) struct SectionReader<'a, 'r> {
    pub section: SectionRef<'a>,
    pub report: &'r mut Report,
}

impl<'a, 'r> SectionReader<'a, 'r> {
    pub(crate) fn new(section: SectionRef<'a>, report: &'r mut Report) -> Self {
        SectionReader { section, report }
    }

    /// The key of this name, if it is there and not empty.
    pub(crate) fn key(&self, name: &str) -> Option<(IniKey, &'a str)> {
        let key = self.section.key(name)?;
        let text = self.section.str(key.value);
        (!text.is_empty()).then_some((key, text))
    }

    /// The text of a key.
    pub(crate) fn text(&self, name: &str) -> Option<String> {
        self.key(name).map(|(_, text)| text.to_owned())
    }

    /// The number of a key, 0 to `most`.
    pub(crate) fn number(&mut self, name: &str, most: u64, weight: Weight) -> Option<u64> {
        let (key, text) = self.key(name)?;
        self.number_of(key, text, most, weight)
    }

    /// The number of a key that was found.
    pub(crate) fn number_of(&mut self, key: IniKey, text: &str, most: u64, weight: Weight) -> Option<u64> {
        // Behind a number a `;` can only be a comment, even without a space.
        let text = text.split(';').next().unwrap_or_default();
        match number::number(text) {
            Err(wrong) => {
                self.say(key, weight, wrong.to_string(), wrong.hint());
                None
            }
            Ok(number) => match u64::try_from(number.value).ok().filter(|value| *value <= most) {
                Some(value) => {
                    if number.is_octal {
                        self.say_octal(key, text, number.value);
                    }
                    Some(value)
                }
                None => {
                    self.say(key, weight, format!("`{}` is not 0 to {most}", shown(text)), "check the number");
                    None
                }
            },
        }
    }

    /// Whether a key is 1; absent is no.
    pub(crate) fn flag(&mut self, name: &str) -> bool {
        match self.key(name) {
            Some((_, "1")) => true,
            Some((_, "0")) | None => false,
            Some((key, text)) => {
                let value = number::number(text.split(';').next().unwrap_or_default()).map(|number| number.value);
                match value {
                    Ok(0) => false,
                    Ok(1) => true,
                    _ => {
                        let (is, as_what) = if text.eq_ignore_ascii_case("true") { (true, 1) } else { (false, 0) };
                        let message = format!("`{}` is taken as {as_what}", shown(text));
                        self.say(key, Weight::Warning, message, "write 1 or 0");
                        is
                    }
                }
            }
        }
    }

    /// Warns that a leading zero makes the number another one.
    pub(crate) fn say_octal(&mut self, key: IniKey, text: &str, value: i128) {
        let message = format!("`{}` is octal and means {value}", shown(text));
        self.say(key, Weight::Warning, message, "octal by its leading 0; write it without, or with 0x");
    }

    /// Reports something about a key.
    pub(crate) fn say(&mut self, key: IniKey, weight: Weight, message: impl AsRef<str>, hint: impl Into<String>) {
        let at = if key.value.start < key.value.end { key.value } else { key.key };
        let name = shown(self.section.str(key.key));
        let message = format!("[{}] {name}: {}", shown(self.section.name()), message.as_ref());
        let finding = match weight {
            Weight::Error => Problem::error(at, message),
            Weight::Warning => Problem::warning(at, message),
        };
        self.report.add(finding.hint(hint));
    }

    /// Reports something about the section as a whole.
    pub(crate) fn say_here(&mut self, weight: Weight, message: impl AsRef<str>, hint: impl Into<String>) {
        let message = format!("[{}] {}", shown(self.section.name()), message.as_ref());
        let finding = match weight {
            Weight::Error => Problem::error(self.section.at(), message),
            Weight::Warning => Problem::warning(self.section.at(), message),
        };
        self.report.add(finding.hint(hint));
    }

    /// The numbered keys `1=`, `2=` … of a list, with the count that its key `counted_by` states.
    ///
    /// The count and the entries must agree: a program that relies on the count would lose the rest.
    pub(crate) fn numbered(&mut self, counted_by: &str) -> Vec<(u64, IniKey, &'a str)> {
        let mut found = Vec::new();
        for &key in self.section.keys() {
            let name = self.section.str(key.key);
            if name.bytes().all(|byte| byte.is_ascii_digit())
                && let Ok(number) = name.parse()
            {
                found.push((number, key, self.section.str(key.value)));
            }
        }
        match self.key(counted_by) {
            Some((key, text)) => {
                if let Some(count) = self.number_of(key, text, u64::from(u16::MAX), Weight::Error)
                    && count != found.len() as u64
                {
                    let message = format!("it says {count}, but the list has {}", found.len());
                    self.say(key, Weight::Error, message, "correct the number, or find what is missing or too much");
                }
            }
            None if found.is_empty() => {
                let message = format!("has no {counted_by}");
                self.say_here(Weight::Warning, message, format!("write {counted_by}=0"));
            }
            None => {
                let message = format!("has no {counted_by}: completeness cannot be checked");
                self.say_here(Weight::Error, message, format!("write {counted_by}={}", found.len()));
            }
        }
        found
    }
}
