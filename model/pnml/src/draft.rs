//! The elements of one net as they stand in the file, with their places.
//!
//! An element's own data is checked here; its references are only written down, because their targets may come later in
//! the file. Pages are a matter of drawing: everything on them is of the same net.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::kinds::{is_coloured_label, is_ordinary_arc, is_place_transition};
use crate::label::{label, name, number};
use crate::limits::{ARCS_MAX, NODES_MAX};
use crate::xml::{AttributeValue, Tag, Xml, XmlAbort};
use linewright_diagnostics::{At, Problem, Report, shown};

/// An id, as a number: the same text is the same number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Id(pub u32);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeKind {
    Place,
    Transition,
}

impl NodeKind {
    pub(crate) fn word(self) -> &'static str {
        match self {
            NodeKind::Place => "place",
            NodeKind::Transition => "transition",
        }
    }
}

/// A place, a transition, or another appearance of one.
#[derive(Debug)]
pub(crate) struct DraftNode {
    pub kind: NodeKind,
    pub id: Id,
    pub at: At,
    pub is: Being,
}

#[derive(Debug)]
pub(crate) enum Being {
    Itself {
        name: Option<String>,
        tokens: u32,
    },
    /// A reference node: its target, and the place of the reference.
    Another {
        id: Id,
        at: At,
    },
}

#[derive(Debug)]
pub(crate) struct DraftArc {
    pub id: Option<Id>,
    pub source: Id,
    pub target: Id,
    pub weight: u32,
    /// The start tag, and the values of `source` and `target` in it.
    pub at: At,
    pub source_at: At,
    pub target_at: At,
}

/// One net of a file.
#[derive(Debug, Default)]
pub(crate) struct DraftNet<'a> {
    pub at: At,
    pub name: Option<String>,
    /// The text of each id.
    pub ids: Vec<Cow<'a, str>>,
    numbers: HashMap<Cow<'a, str>, Id>,
    pub nodes: Vec<DraftNode>,
    pub arcs: Vec<DraftArc>,
    /// The priority of the first transition that has one: others may have the same, which then means nothing.
    priority: Option<String>,
}

/// Reads the net at position `chosen` among the nets of the file; none if that cannot be done at all.
pub(crate) fn read<'a>(text: &'a str, chosen: usize, report: &mut Report) -> Option<DraftNet<'a>> {
    let mut reader = DraftReader { xml: Xml::new(text), report, draft: DraftNet::default() };
    reader.file(chosen).ok()?;
    Some(reader.draft)
}

struct DraftReader<'a, 'r> {
    xml: Xml<'a>,
    report: &'r mut Report,
    draft: DraftNet<'a>,
}

impl<'a> DraftReader<'a, '_> {
    fn file(&mut self, chosen: usize) -> Result<(), XmlAbort> {
        self.child()?;
        let mut position = 0;
        while let Some(tag) = self.child()? {
            if tag.name != "net" {
                self.xml.skip(self.report)?;
                continue;
            }
            if position == chosen {
                return self.net(&tag);
            }
            position += 1;
            self.xml.skip(self.report)?;
        }
        Ok(())
    }

    fn net(&mut self, tag: &Tag<'a>) -> Result<(), XmlAbort> {
        let [id, net_type] = self.attributes(tag, ["id", "type"]);
        if let Some(net_type) = net_type.filter(|net_type| !is_place_transition(&net_type.text)) {
            let finding = Problem::error(net_type.at, format!("this net is of the type `{}`", shown(&net_type.text)));
            self.report.add(finding.hint(
                "only place/transition nets are read: unfold it, or export it as \
                 http://www.pnml.org/version-2009/grammar/ptnet",
            ));
            return Err(XmlAbort);
        }
        self.draft.at = tag.at;
        self.page(true)?;
        if self.draft.name.is_none() {
            self.draft.name = id.map(|id| id.text.into_owned()).filter(|id| !id.is_empty());
        }
        Ok(())
    }

    /// Contents of a net, or of a page. Pages lie in pages as deep as elements may.
    fn page(&mut self, is_net: bool) -> Result<(), XmlAbort> {
        while let Some(tag) = self.child()? {
            match tag.name {
                "page" => self.page(false)?,
                "name" if is_net => {
                    let text = label(&mut self.xml, self.report)?;
                    self.draft.name = text.and_then(|text| name(text, self.report));
                }
                "place" => self.node(&tag, NodeKind::Place)?,
                "transition" => self.node(&tag, NodeKind::Transition)?,
                "referencePlace" => self.reference(&tag, NodeKind::Place)?,
                "referenceTransition" => self.reference(&tag, NodeKind::Transition)?,
                "arc" => self.arc(&tag)?,
                other => self.unknown(&tag, other)?,
            }
        }
        Ok(())
    }

    fn node(&mut self, tag: &Tag<'a>, kind: NodeKind) -> Result<(), XmlAbort> {
        let [id, named, marked] = self.attributes(tag, ["id", "name", "initialMarking"]);
        let what = |of: &str, id: &Option<AttributeValue<'_>>| {
            format!("{of} of the {} `{}`", kind.word(), shown(id.as_ref().map_or("", |id| &id.text)))
        };
        let mut name_label = None;
        let mut marking: Option<AttributeValue<'a>> = None;
        while let Some(child) = self.child()? {
            match (child.name, kind) {
                ("name", _) => name_label = label(&mut self.xml, self.report)?,
                ("initialMarking", NodeKind::Place) => {
                    let text = label(&mut self.xml, self.report)?;
                    if marking.is_some() {
                        let finding = Problem::error(child.at, format!("{} is given twice", what("the marking", &id)));
                        self.report.add(finding.hint("remove one of the two"));
                    }
                    marking = text.or(marking);
                }
                ("capacity", NodeKind::Place) => {
                    let text = label(&mut self.xml, self.report)?;
                    let limit = text.as_ref().and_then(|text| number(text, || what("the capacity", &id), self.report));
                    if let Some(limit @ 1..) = limit {
                        let finding = Problem::error(child.at, format!("{} is {limit}", what("the capacity", &id)));
                        self.report.add(finding.hint("capacities are not read; write it as a complementary place"));
                    }
                }
                ("priority", NodeKind::Transition) => {
                    let text = label(&mut self.xml, self.report)?;
                    self.priority(text, &child, || what("the priority", &id));
                }
                (other, _) => self.unknown(&child, other)?,
            }
        }
        let marking = marking.or(marked.filter(|_| kind == NodeKind::Place));
        let tokens = marking.and_then(|text| number(&text, || what("the initial marking", &id), self.report));
        let name = name_label.or(named).and_then(|text| name(text, self.report));
        self.add(tag, kind, id, Being::Itself { name, tokens: tokens.unwrap_or(0) })
    }

    fn reference(&mut self, tag: &Tag<'a>, kind: NodeKind) -> Result<(), XmlAbort> {
        let [id, to] = self.attributes(tag, ["id", "ref"]);
        self.xml.skip(self.report)?;
        let Some(to) = to else {
            let finding = Problem::error(tag.at, format!("this reference to a {} has no `ref`", kind.word()));
            self.report.add(finding.hint(format!("write the id of the {} it stands for", kind.word())));
            return Ok(());
        };
        let at = to.at;
        let to = self.id(to);
        self.add(tag, kind, id, Being::Another { id: to, at })
    }

    fn add(
        &mut self,
        tag: &Tag<'a>,
        kind: NodeKind,
        id: Option<AttributeValue<'a>>,
        is: Being,
    ) -> Result<(), XmlAbort> {
        let Some(id) = id.filter(|id| !id.text.is_empty()) else {
            let finding = Problem::error(tag.at, format!("this {} has no id", kind.word()));
            self.report.add(finding.hint("arcs find their ends by id: give it one"));
            return Ok(());
        };
        if self.draft.nodes.len() == NODES_MAX {
            let finding = Problem::error(tag.at, format!("the net has more than {NODES_MAX} places and transitions"));
            self.report.add(finding.hint("it is too large to be read"));
            return Err(XmlAbort);
        }
        let id = self.id(id);
        self.draft.nodes.push(DraftNode { kind, id, at: tag.at, is });
        Ok(())
    }

    fn arc(&mut self, tag: &Tag<'a>) -> Result<(), XmlAbort> {
        let names = ["id", "source", "target", "type", "inscription"];
        let [id, source, target, arc_type, inscribed] = self.attributes(tag, names);
        let mut inscription: Option<AttributeValue<'a>> = None;
        let mut types: Vec<AttributeValue<'a>> = arc_type.into_iter().collect();
        while let Some(child) = self.child()? {
            match child.name {
                "inscription" => {
                    let text = label(&mut self.xml, self.report)?;
                    if inscription.is_some() {
                        let finding = Problem::error(child.at, "this arc has two inscriptions");
                        self.report.add(finding.hint("remove one of the two"));
                    }
                    inscription = text.or(inscription);
                }
                "type" | "arctype" => {
                    types.extend(self.attributes(&child, ["value"]).into_iter().flatten());
                    types.extend(label(&mut self.xml, self.report)?);
                }
                other => self.unknown(&child, other)?,
            }
        }
        let what = |id: &Option<AttributeValue<'_>>| {
            id.as_ref().map_or("this arc".into(), |id| format!("the arc `{}`", shown(&id.text)))
        };
        if let Some(other) = types.iter().find(|text| !is_ordinary_arc(&text.text)) {
            let finding = Problem::error(other.at, format!("{} is of the type `{}`", what(&id), shown(&other.text)));
            self.report.add(finding.hint("only ordinary arcs are read, which take and give tokens"));
        }
        let weight = inscription.or(inscribed);
        let weight_at = weight.as_ref().map_or(tag.at, |text| text.at);
        let weight = weight.and_then(|text| number(&text, || format!("the weight of {}", what(&id)), self.report));
        if weight == Some(0) {
            let finding = Problem::error(weight_at, format!("the weight of {} is 0", what(&id)));
            self.report.add(finding.hint("an arc moves at least one token; leave the arc out"));
        }
        let (Some(source), Some(target)) = (source, target) else {
            let finding = Problem::error(tag.at, format!("{} lacks `source` or `target`", what(&id)));
            self.report.add(finding.hint("write the ids of the nodes it joins"));
            return Ok(());
        };
        if self.draft.arcs.len() == ARCS_MAX {
            let finding = Problem::error(tag.at, format!("the net has more than {ARCS_MAX} arcs"));
            self.report.add(finding.hint("it is too large to be read"));
            return Err(XmlAbort);
        }
        let (source_at, target_at) = (source.at, target.at);
        let id = id.filter(|id| !id.text.is_empty()).map(|id| self.id(id));
        let (source, target) = (self.id(source), self.id(target));
        let weight = weight.unwrap_or(1).max(1);
        self.draft.arcs.push(DraftArc { id, source, target, weight, at: tag.at, source_at, target_at });
        Ok(())
    }

    /// Priorities that differ decide between transitions, and are not read.
    fn priority(&mut self, text: Option<AttributeValue<'a>>, tag: &Tag<'a>, what: impl Fn() -> String) {
        let Some(text) = text.filter(|text| !text.text.is_empty()) else { return };
        match &self.draft.priority {
            None => self.draft.priority = Some(text.text.into_owned()),
            Some(first) if *first == text.text => {}
            Some(first) => {
                let finding = Problem::error(
                    tag.at,
                    format!("{} is {}, another one's is {}", what(), shown(&text.text), shown(first)),
                );
                self.report.add(finding.hint("priorities are not read: give all transitions the same"));
            }
        }
    }

    /// Passes over an element that means nothing here, or refuses one that is known to mean something.
    fn unknown(&mut self, tag: &Tag<'a>, element: &str) -> Result<(), XmlAbort> {
        if is_coloured_label(element) {
            let finding = Problem::error(tag.at, format!("`{}` belongs to a coloured net", shown(element)));
            self.report.add(finding.hint("only place/transition nets are read; unfold it first"));
        } else if !matches!(element, "toolspecific" | "graphics")
            && let [Some(_), Some(_)] = tag.attributes(&self.xml, ["source", "target"], &mut Report::of_excerpts())
        {
            let finding =
                Problem::error(tag.at, format!("`{}` is a kind of arc that is not known here", shown(element)));
            self.report.add(finding.hint("only ordinary arcs are read, which take and give tokens"));
        }
        self.xml.skip(self.report)
    }

    fn child(&mut self) -> Result<Option<Tag<'a>>, XmlAbort> {
        self.xml.child(self.report)
    }

    fn attributes<const N: usize>(&mut self, tag: &Tag<'a>, names: [&str; N]) -> [Option<AttributeValue<'a>>; N] {
        tag.attributes(&self.xml, names, self.report)
    }

    /// The number of an id. There are at most three for each node and arc, far fewer than 32 bits can count.
    fn id(&mut self, text: AttributeValue<'a>) -> Id {
        let draft = &mut self.draft;
        let next = Id(draft.ids.len() as u32);
        *draft.numbers.entry(text.text).or_insert_with_key(|text| {
            draft.ids.push(text.clone());
            next
        })
    }
}
