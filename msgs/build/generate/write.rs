//! Writes Rust text: a struct for each message, with its constants, its limits and its place in ROS 2.

use super::read::{Doc, FieldType, MessageConstant, MessageField, MessageSection};

/// Messages whose names mean something else in Rust.
const RENAMED: [(&str, &str); 4] =
    [("String", "Text"), ("Bool", "Flag"), ("State", "NodeState"), ("Transition", "NodeTransition")];

/// Services whose names are not written as Rust's types are; the service keeps its name, its two messages do not.
const PARTS: [(&str, &str); 4] =
    [("CORead", "CoRead"), ("COWrite", "CoWrite"), ("COReadID", "CoReadId"), ("COWriteID", "CoWriteId")];

/// Messages of which more is checked than lengths, in `src/meaning.rs`.
const CHECKED: [&str; 16] = [
    "Answer",
    "CellState",
    "LineState",
    "ModeOrder",
    "OrderEnd",
    "OrderState",
    "ProcessImage",
    "ProductionState",
    "RunTaskFeedback",
    "RunTaskGoal",
    "RunTaskResult",
    "SecureOrder",
    "SetResourceRequest",
    "StationEvent",
    "StationState",
    "SubmitOrdersRequest",
];

/// Messages with a floating point number, for those that have one of them inside. Without an entry these do not compile.
const WITH_FLOATS: [&str; 4] = ["FloatingPointRange", "Parameter", "ParameterDescriptor", "ParameterValue"];

/// Names of fields that mean something else in Rust.
const RUST_WORDS: [&str; 1] = ["type"];

/// Interface of a text.
pub struct InterfaceText<'a> {
    pub package: &'a str,
    pub name: &'a str,
    pub doc: &'a Doc,
}

impl InterfaceText<'_> {
    pub fn message(&self, section: &MessageSection) -> String {
        self.structure(&rust_name(self.name), self.name, &self.about(), section)
    }

    pub fn service(&self, request: &MessageSection, response: &MessageSection) -> String {
        let mut text = self.group("RosService", &["Request", "Response"]);
        text += &self.part("Request", request);
        text + &self.part("Response", response)
    }

    pub fn action(&self, goal: &MessageSection, result: &MessageSection, feedback: &MessageSection) -> String {
        let mut text = self.group("RosAction", &["Goal", "Result", "Feedback"]);
        text += &self.part("Goal", goal);
        text += &self.part("Result", result);
        text + &self.part("Feedback", feedback)
    }

    fn about(&self) -> String {
        let InterfaceText { package, name, doc } = self;
        format!("{}///\n/// `{package}/{name}` in ROS 2.\n", comment(doc, ""))
    }

    /// A type without values that ties the messages of a service or an action together.
    fn group(&self, of: &str, parts: &[&str]) -> String {
        let (name, package, types) = (self.name, self.package, self.parts());
        let types: String = parts.iter().map(|part| format!("    type {part} = {types}{part};\n")).collect();
        format!(
            "{}#[derive(Debug, Clone, Copy)]\npub struct {name};\n\n\
             impl crate::{of} for {name} {{\n    \
             const PACKAGE: &'static str = \"{package}\";\n    \
             const NAME: &'static str = \"{name}\";\n{types}}}\n\n",
            self.about()
        )
    }

    /// Beginning of the names of its messages.
    fn parts(&self) -> &str {
        PARTS.iter().find(|(ros, _)| *ros == self.name).map_or(self.name, |(_, rust)| rust)
    }

    fn part(&self, part: &str, section: &MessageSection) -> String {
        let about = format!("/// {part} of [`{}`].\n", self.name);
        self.structure(&format!("{}{part}", self.parts()), &format!("{}_{part}", self.name), &about, section)
    }

    fn structure(&self, rust: &str, ros: &str, about: &str, section: &MessageSection) -> String {
        let package = self.package;
        let mut fields: String = section.fields.iter().map(field).collect();
        if section.fields.is_empty() {
            // As the generators of ROS 2 have it.
            fields = "    /// A message without fields is sent as one byte.\n    \
                      pub structure_needs_at_least_one_member: u8,\n"
                .to_owned();
        }
        let has_float = |field: &MessageField| field.kind.has_float(&WITH_FLOATS);
        let eq = if section.fields.iter().any(has_float) { "" } else { " Eq," };
        let mut text = format!(
            "{about}#[derive(Debug, Clone, PartialEq,{eq} Default, serde::Serialize, serde::Deserialize)]\n\
             pub struct {rust} {{\n{fields}}}\n\n"
        );
        if !section.constants.is_empty() {
            let constants: String = section.constants.iter().map(constant).collect();
            text += &format!("impl {rust} {{\n{constants}}}\n\n");
        }
        text += &limits(rust, &section.fields);
        if !CHECKED.contains(&rust) {
            text += &format!("impl crate::meaning::Meaning for {rust} {{}}\n\n");
        }
        text + &format!(
            "impl crate::RosMessage for {rust} {{\n    \
             const PACKAGE: &'static str = \"{package}\";\n    \
             const NAME: &'static str = \"{ros}\";\n    \
             fn validate(&self) -> Result<(), crate::Invalid> {{\n        \
             crate::RosField::check_bounds(self, \"{ros}\")?;\n        \
             crate::meaning::Meaning::meaning(self)\n    }}\n}}\n\n"
        )
    }
}

fn field(field: &MessageField) -> String {
    format!("{}    pub {}: {},\n", comment(&field.doc, "    "), field_name(&field.name), rust_type(&field.kind))
}

fn field_name(ros: &str) -> String {
    if RUST_WORDS.contains(&ros) { format!("r#{ros}") } else { ros.to_owned() }
}

fn constant(constant: &MessageConstant) -> String {
    let MessageConstant { doc, kind, name, value } = constant;
    let (doc, rust) = (comment(doc, "    "), rust_type(kind));
    match kind {
        FieldType::Byte => format!("{doc}    pub const {name}: {rust} = crate::Byte({value});\n"),
        _ => format!("{doc}    pub const {name}: {rust} = {value};\n"),
    }
}

/// Numbers have no length.
fn limits(rust: &str, fields: &[MessageField]) -> String {
    let long = fields.iter().filter(|field| !matches!(field.kind, FieldType::Plain(_) | FieldType::Byte));
    let check = |MessageField { name, .. }: &MessageField| {
        format!("        crate::RosField::check_bounds(&self.{name}, &format!(\"{{path}}.{name}\"))?;\n")
    };
    let checks: String = long.map(check).collect();
    let path = if checks.is_empty() { "_path" } else { "path" };
    format!(
        "impl crate::RosField for {rust} {{\n    \
         fn check_bounds(&self, {path}: &str) -> Result<(), crate::Invalid> {{\n{checks}        Ok(())\n    }}\n}}\n\n"
    )
}

fn comment(doc: &Doc, indent: &str) -> String {
    doc.iter().map(|line| format!("{indent}/// {line}").trim_end().to_owned() + "\n").collect()
}

fn rust_type(kind: &FieldType) -> String {
    match kind {
        FieldType::Plain(rust) => (*rust).to_owned(),
        FieldType::Byte => "crate::Byte".to_owned(),
        FieldType::Text => "String".to_owned(),
        FieldType::Message(_, name) => rust_name(name),
        FieldType::Sequence(element, None) => format!("Vec<{}>", rust_type(element)),
        FieldType::Sequence(element, Some(most)) => format!("crate::Bounded<{}, {most}>", rust_type(element)),
    }
}

fn rust_name(ros: &str) -> String {
    RENAMED.iter().find(|(from, _)| *from == ros).map_or(ros, |(_, to)| to).to_owned()
}
