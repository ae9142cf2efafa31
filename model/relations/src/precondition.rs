//! What has to be finished before an operation: a logical expression of operations.

use std::collections::BTreeSet;

use linewright_text::TextRange;

use crate::OperationId;

/// A logical expression of finished operations.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Precondition {
    /// Nothing.
    Always,
    /// This operation, on the same product.
    Finished(OperationId),
    /// All of these; at least two.
    All(Vec<Precondition>),
    /// One of these; at least two.
    Any(Vec<Precondition>),
}

/// What is wrong with an expression, and where in it.
#[derive(Debug)]
pub(crate) struct WrongExpression {
    pub at: TextRange,
    pub message: String,
}

/// A sign or a name, and where.
#[derive(Clone, Debug, PartialEq)]
enum Sign {
    Open,
    Close,
    And,
    Or,
    Name(String),
}

impl Precondition {
    /// The operations that occur in it, each as often as it does.
    pub fn operations(&self) -> Vec<OperationId> {
        match self {
            Precondition::Always => Vec::new(),
            Precondition::Finished(operation) => vec![*operation],
            Precondition::All(parts) | Precondition::Any(parts) => {
                parts.iter().flat_map(Precondition::operations).collect()
            }
        }
    }

    /// The operations without which it never holds.
    pub fn required(&self) -> BTreeSet<OperationId> {
        match self {
            Precondition::Always => BTreeSet::new(),
            Precondition::Finished(operation) => BTreeSet::from([*operation]),
            Precondition::All(parts) => parts.iter().flat_map(Precondition::required).collect(),
            Precondition::Any(parts) => {
                let mut parts = parts.iter().map(Precondition::required);
                let first = parts.next().unwrap_or_default();
                parts.fold(first, |all, part| all.intersection(&part).copied().collect())
            }
        }
    }

    /// Whether it holds where `is_finished` of its operations.
    pub fn holds(&self, is_finished: &impl Fn(OperationId) -> bool) -> bool {
        match self {
            Precondition::Always => true,
            Precondition::Finished(operation) => is_finished(*operation),
            Precondition::All(parts) => parts.iter().all(|part| part.holds(is_finished)),
            Precondition::Any(parts) => parts.iter().any(|part| part.holds(is_finished)),
        }
    }

    /// As tables have it, with names from `name`; empty for [`Precondition::Always`].
    pub fn text(&self, name: &dyn Fn(OperationId) -> String) -> String {
        let (parts, word) = match self {
            Precondition::Always => return String::new(),
            Precondition::Finished(operation) => return name(*operation),
            Precondition::All(parts) => (parts, " and "),
            Precondition::Any(parts) => (parts, " or "),
        };
        let part = |part: &Precondition| match part {
            Precondition::All(_) | Precondition::Any(_) => format!("({})", part.text(name)),
            Precondition::Always | Precondition::Finished(_) => part.text(name),
        };
        parts.iter().map(part).collect::<Vec<_>>().join(word)
    }

    /// Reads `63 and (98 or 99)`; signs `,` and `&` mean and, `|` means or.
    /// Names are looked up by `find`; one that it does not find is left out.
    pub(crate) fn read(
        text: &str,
        find: &mut dyn FnMut(&str, TextRange) -> Option<OperationId>,
    ) -> Result<Precondition, WrongExpression> {
        let signs = signs(text);
        if signs.is_empty() {
            return Ok(Precondition::Always);
        }
        let mut reader = Reader { signs: &signs, next: 0, end: text.len(), depth: 0 };
        let read = reader.any(find)?;
        match reader.signs.get(reader.next) {
            None => Ok(read),
            Some((_, at)) => Err(WrongExpression { at: at.clone(), message: "`)` closes nothing".to_owned() }),
        }
    }
}

/// Names and signs of a text.
fn signs(text: &str) -> Vec<(Sign, TextRange)> {
    let mut found = Vec::new();
    let mut begin = None;
    let ends = text.char_indices().map(|(at, sign)| (at, Some(sign))).chain([(text.len(), None)]);
    for (at, sign) in ends {
        let is_part = sign.is_some_and(|sign| !sign.is_whitespace() && !"(),&|".contains(sign));
        match (is_part, begin) {
            (true, None) => begin = Some(at),
            (false, Some(from)) => {
                let sign = match &text[from..at] {
                    "and" => Sign::And,
                    "or" => Sign::Or,
                    name => Sign::Name(name.to_owned()),
                };
                found.push((sign, from..at));
                begin = None;
            }
            _ => {}
        }
        let sign = match sign {
            Some('(') => Sign::Open,
            Some(')') => Sign::Close,
            Some(',' | '&') => Sign::And,
            Some('|') => Sign::Or,
            _ => continue,
        };
        found.push((sign, at..at + 1));
    }
    found
}

/// Deeper brackets are no expression of a planner.
const DEPTH_MAX: usize = 20;

struct Reader<'a> {
    signs: &'a [(Sign, TextRange)],
    next: usize,
    end: usize,
    depth: usize,
}

type Find<'f> = &'f mut dyn FnMut(&str, TextRange) -> Option<OperationId>;

impl Reader<'_> {
    fn any(&mut self, find: Find<'_>) -> Result<Precondition, WrongExpression> {
        let mut parts = vec![self.all(find)?];
        while self.takes(&Sign::Or) {
            parts.push(self.all(find)?);
        }
        Ok(joined(parts, Precondition::Any))
    }

    fn all(&mut self, find: Find<'_>) -> Result<Precondition, WrongExpression> {
        let mut parts = vec![self.one(find)?];
        loop {
            let goes_on = matches!(self.signs.get(self.next), Some((Sign::Name(_) | Sign::Open, _)));
            if !self.takes(&Sign::And) && !goes_on {
                return Ok(joined(parts, Precondition::All));
            }
            parts.push(self.one(find)?);
        }
    }

    fn one(&mut self, find: Find<'_>) -> Result<Precondition, WrongExpression> {
        let (sign, at) = match self.signs.get(self.next) {
            Some((sign, at)) => (sign.clone(), at.clone()),
            None => return Err(self.wrong(self.end..self.end, "an operation is missing at the end")),
        };
        self.next += 1;
        match sign {
            Sign::Name(name) => Ok(find(&name, at).map_or(Precondition::Always, Precondition::Finished)),
            Sign::Open if self.depth == DEPTH_MAX => Err(self.wrong(at, "brackets too deep")),
            Sign::Open => {
                self.depth += 1;
                let inside = self.any(find)?;
                self.depth -= 1;
                if !self.takes(&Sign::Close) {
                    return Err(self.wrong(at, "`(` is not closed"));
                }
                Ok(inside)
            }
            Sign::Close | Sign::And | Sign::Or => Err(self.wrong(at, "an operation is missing before this")),
        }
    }

    fn takes(&mut self, sign: &Sign) -> bool {
        let takes = self.signs.get(self.next).is_some_and(|(next, _)| next == sign);
        self.next += usize::from(takes);
        takes
    }

    fn wrong(&self, at: TextRange, message: &str) -> WrongExpression {
        WrongExpression { at, message: message.to_owned() }
    }
}

/// One part is itself; parts that could not be read are left out, and brackets that change nothing.
fn joined(parts: Vec<Precondition>, join: fn(Vec<Precondition>) -> Precondition) -> Precondition {
    let whole = std::mem::discriminant(&join(Vec::new()));
    let mut flat = Vec::new();
    for part in parts {
        let is_same = std::mem::discriminant(&part) == whole;
        match part {
            Precondition::Always => {}
            Precondition::All(inside) | Precondition::Any(inside) if is_same => flat.extend(inside),
            part => flat.push(part),
        }
    }
    match flat.len() {
        0 => Precondition::Always,
        1 => flat.remove(0),
        _ => join(flat),
    }
}
