//! Type descriptions and their hashes, as ROS 2 has them since Iron (REP-2016, `RIHS01`): the SHA-256 of a JSON text of
//! a type with all types inside, without comments, constants and default values.

use std::collections::{BTreeMap, BTreeSet};

use sha2::{Digest, Sha256};

use super::read::{FieldType, MessageField, MessageSection};

/// Types by their full names, `package/kind/Name`, each with its fields.
pub struct TypeDescriptions(BTreeMap<String, Vec<DescribedField>>);

struct DescribedField {
    name: String,
    /// The number that `type_description_interfaces/msg/FieldType` gives it.
    type_id: u8,
    /// Elements at most; 0 without a bound.
    capacity: usize,
    /// Full name of a type of its own, else empty.
    nested: String,
}

const NESTED: u8 = 1;
const INT8: u8 = 2;
const UINT8: u8 = 3;
const INT64: u8 = 8;
const BOOLEAN: u8 = 15;
/// Added to the number of an element's type.
const ARRAY: u8 = 48;
const BOUNDED_SEQUENCE: u8 = 96;
const UNBOUNDED_SEQUENCE: u8 = 144;

const TIME: &str = "builtin_interfaces/msg/Time";
const GOAL_ID: &str = "unique_identifier_msgs/msg/UUID";
const EVENT_INFO: &str = "service_msgs/msg/ServiceEventInfo";

impl DescribedField {
    fn plain(name: &str, type_id: u8) -> Self {
        DescribedField { name: name.to_owned(), type_id, capacity: 0, nested: String::new() }
    }

    fn bytes(name: &str, capacity: usize) -> Self {
        DescribedField { capacity, ..DescribedField::plain(name, UINT8 + ARRAY) }
    }

    fn nested(name: &str, of: &str) -> Self {
        DescribedField { nested: of.to_owned(), ..DescribedField::plain(name, NESTED) }
    }

    /// None, or one of these.
    fn at_most_one(name: &str, of: &str) -> Self {
        DescribedField { type_id: NESTED + BOUNDED_SEQUENCE, capacity: 1, ..DescribedField::nested(name, of) }
    }

    fn read(package: &str, field: &MessageField) -> Self {
        let (element, more, capacity) = match &field.kind {
            FieldType::Sequence(element, None) => (&**element, UNBOUNDED_SEQUENCE, 0),
            FieldType::Sequence(element, Some(most)) => (&**element, BOUNDED_SEQUENCE, *most),
            single => (single, 0, 0),
        };
        let nested = match element {
            FieldType::Message(of, name) => format!("{}/msg/{name}", of.as_deref().unwrap_or(package)),
            _ => String::new(),
        };
        DescribedField { name: field.name.clone(), type_id: type_id(element) + more, capacity, nested }
    }

    fn json(&self) -> String {
        let DescribedField { name, type_id, capacity, nested } = self;
        format!(
            "{{\"name\": \"{name}\", \"type\": {{\"type_id\": {type_id}, \"capacity\": {capacity}, \
             \"string_capacity\": 0, \"nested_type_name\": \"{nested}\"}}}}"
        )
    }
}

impl Default for TypeDescriptions {
    /// The types that every service and action has inside.
    fn default() -> Self {
        let event_info = vec![
            DescribedField::plain("event_type", UINT8),
            DescribedField::nested("stamp", TIME),
            DescribedField::bytes("client_gid", 16),
            DescribedField::plain("sequence_number", INT64),
        ];
        let goal_id = vec![DescribedField::bytes("uuid", 16)];
        TypeDescriptions([(EVENT_INFO.to_owned(), event_info), (GOAL_ID.to_owned(), goal_id)].into())
    }
}

impl TypeDescriptions {
    /// Adds an interface, by package, kind and name, with all types that ROS 2 makes of it.
    pub fn add(&mut self, of: &[&str; 3], sections: &[MessageSection]) {
        let fields = |section: &MessageSection| -> Vec<DescribedField> {
            let fields: Vec<_> = section.fields.iter().map(|field| DescribedField::read(of[0], field)).collect();
            match fields.is_empty() {
                true => vec![DescribedField::plain("structure_needs_at_least_one_member", UINT8)],
                false => fields,
            }
        };
        let name = of.join("/");
        match sections {
            [message] => drop(self.0.insert(name, fields(message))),
            [request, response] => self.service(&name, fields(request), fields(response)),
            [goal, result, feedback] => self.action(&name, [fields(goal), fields(result), fields(feedback)]),
            _ => {}
        }
    }

    fn service(&mut self, name: &str, request: Vec<DescribedField>, response: Vec<DescribedField>) {
        let [to, back, event] = ["Request", "Response", "Event"].map(|part| format!("{name}_{part}"));
        let of_event = vec![
            DescribedField::nested("info", EVENT_INFO),
            DescribedField::at_most_one("request", &to),
            DescribedField::at_most_one("response", &back),
        ];
        let whole = vec![
            DescribedField::nested("request_message", &to),
            DescribedField::nested("response_message", &back),
            DescribedField::nested("event_message", &event),
        ];
        self.0.extend([(name.to_owned(), whole), (to, request), (back, response), (event, of_event)]);
    }

    fn action(&mut self, name: &str, parts: [Vec<DescribedField>; 3]) {
        let [goal, result, feedback] = ["Goal", "Result", "Feedback"].map(|part| format!("{name}_{part}"));
        let [send_goal, get_result, message] =
            ["SendGoal", "GetResult", "FeedbackMessage"].map(|part| format!("{name}_{part}"));
        let goal_id = || DescribedField::nested("goal_id", GOAL_ID);
        let to = vec![goal_id(), DescribedField::nested("goal", &goal)];
        let back = vec![DescribedField::plain("accepted", BOOLEAN), DescribedField::nested("stamp", TIME)];
        self.service(&send_goal, to, back);
        let back = vec![DescribedField::plain("status", INT8), DescribedField::nested("result", &result)];
        self.service(&get_result, vec![goal_id()], back);
        let whole = vec![
            DescribedField::nested("goal", &goal),
            DescribedField::nested("result", &result),
            DescribedField::nested("feedback", &feedback),
            DescribedField::nested("send_goal_service", &send_goal),
            DescribedField::nested("get_result_service", &get_result),
            DescribedField::nested("feedback_message", &message),
        ];
        let of_message = vec![goal_id(), DescribedField::nested("feedback", &feedback)];
        self.0.extend([(name.to_owned(), whole), (message, of_message)]);
        self.0.extend(std::iter::zip([goal, result, feedback], parts));
    }

    /// The hash of a type, or of which type inside it nothing is known.
    pub fn hash(&self, name: &str) -> Result<String, String> {
        let mut inside = BTreeSet::new();
        let mut open = vec![name];
        while let Some(of) = open.pop() {
            let fields = self.0.get(of).ok_or_else(|| format!("{name}: no description of the type {of}"))?;
            let nested = fields.iter().map(|field| field.nested.as_str()).filter(|nested| !nested.is_empty());
            open.extend(nested.filter(|nested| inside.insert(*nested)));
        }
        let inside: Vec<String> = inside.into_iter().map(|of| self.json(of)).collect();
        let text = format!(
            "{{\"type_description\": {}, \"referenced_type_descriptions\": [{}]}}",
            self.json(name),
            inside.join(", ")
        );
        let digits: String = Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(format!("RIHS01_{digits}"))
    }

    fn json(&self, name: &str) -> String {
        let fields: Vec<String> = self.0.get(name).into_iter().flatten().map(DescribedField::json).collect();
        format!("{{\"type_name\": \"{name}\", \"fields\": [{}]}}", fields.join(", "))
    }
}

fn type_id(of: &FieldType) -> u8 {
    match of {
        FieldType::Plain(rust) => match *rust {
            "i8" => INT8,
            "u8" => UINT8,
            "i16" => 4,
            "u16" => 5,
            "i32" => 6,
            "u32" => 7,
            "i64" => INT64,
            "u64" => 9,
            "f64" => 11,
            _ => BOOLEAN,
        },
        FieldType::Byte => 16,
        FieldType::Text => 17,
        FieldType::Message(..) => NESTED,
        FieldType::Sequence(element, _) => type_id(element),
    }
}
