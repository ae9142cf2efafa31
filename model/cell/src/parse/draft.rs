//! The description with its names resolved, as far as they could be.
//!
//! A draft has the shape of the [`crate::Cell`] it may become, but every part may be missing where the text was wrong,
//! and every part has its place. The rules read a draft, so that one unknown name does not hide other errors.

use std::time::Duration;

use linewright_line::Line;
use linewright_text::{Located, NameTable, TextRange};

use super::raw::{RawCell, RawException, RawOn, RawOrder, RawPart, RawResource, RawStep, RawVariant};
use crate::{
    ActivityId, ActivityKind, ControllerId, LeftOut, ParameterSource, Prototype, ResourceId, Role, StopOf, Use,
};

pub(super) struct DraftCell<'a> {
    pub raw: &'a RawCell,
    pub line: Option<&'a Line>,
    pub controllers: NameTable<'a>,
    pub resources: Vec<DraftResource<'a>>,
    /// Synchronisations, then one for each resource that works on parts.
    pub activities: Vec<DraftActivity<'a>>,
    /// Each part type, followed by its variants.
    pub parts: Vec<DraftPart<'a>>,
    pub exceptions: Vec<DraftException<'a>>,
}

pub(super) struct DraftResource<'a> {
    pub raw: &'a RawResource,
    /// Its name for messages; `?` where it has none.
    pub name: &'a str,
    pub prototype: Option<Prototype>,
    pub capacity: Option<u32>,
    pub controller: Option<ControllerId>,
}

pub(super) struct DraftActivity<'a> {
    pub name: String,
    /// Place of its name, or the resource that it belongs to.
    pub at: TextRange,
    pub kind: ActivityKind,
    /// Actions that could be resolved.
    pub uses: Vec<Located<Use>>,
    /// Whether all could.
    pub is_whole: bool,
    pub time: Option<Located<Duration>>,
    pub orders: Vec<DraftOrder<'a>>,
}

pub(super) struct DraftOrder<'a> {
    pub raw: &'a RawOrder,
    pub controller: Option<ControllerId>,
    pub parameters: Vec<(&'a str, ParameterSource)>,
}

pub(super) struct DraftPart<'a> {
    pub raw: &'a RawPart,
    /// Its table, if it is a variant of a described part type.
    pub variant: Option<&'a RawVariant>,
    pub name: &'a str,
    /// The names of its stages, without its own.
    pub stages: Vec<String>,
    pub steps: Vec<DraftStep<'a>>,
    /// Whether the plan's graph is known.
    pub is_whole: bool,
}

#[derive(Clone)]
pub(super) struct DraftStep<'a> {
    pub raw: &'a RawStep,
    pub name: &'a str,
    /// Stages of the part, by number.
    pub from: usize,
    pub to: usize,
    pub on: Vec<Option<ResourceId>>,
}

pub(super) struct DraftException<'a> {
    pub raw: &'a RawException,
    pub activities: Vec<ActivityId>,
    /// By answer, the resources left out after it.
    pub down: Vec<Vec<LeftOut>>,
    pub emergency_stop: Vec<StopOf>,
}

impl<'a> DraftCell<'a> {
    pub fn resource(&self, id: ResourceId) -> &DraftResource<'a> {
        &self.resources[id.index()]
    }

    /// The steps that are written, each once.
    pub fn steps(&self) -> impl Iterator<Item = &DraftStep<'a>> {
        self.parts.iter().filter(|part| part.variant.is_none()).flat_map(|part| &part.steps)
    }

    /// A resource's name, or `outside`.
    pub fn holder(&self, of: Option<ResourceId>) -> &str {
        of.map_or(super::names::OUTSIDE, |id| self.resource(id).name)
    }
}

impl DraftResource<'_> {
    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }
}

impl DraftPart<'_> {
    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        if let Some(variant) = self.variant {
            return variant.name.as_ref().map_or_else(|| variant.at.clone(), |name| name.at.clone());
        }
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }
}

impl<'a> DraftStep<'a> {
    /// The resources that are known, each with how it is written.
    pub fn places(&self) -> impl Iterator<Item = (ResourceId, &'a RawOn)> {
        self.on.iter().zip(&self.raw.on).filter_map(|(on, raw)| Some(((*on)?, raw)))
    }

    /// Place of its name, or else its header.
    pub fn place(&self) -> TextRange {
        self.raw.name.as_ref().map_or_else(|| self.raw.at.clone(), |name| name.at.clone())
    }
}

impl DraftActivity<'_> {
    /// Resources in that role.
    pub fn used(&self, role: Role) -> impl Iterator<Item = &Located<Use>> {
        self.uses.iter().filter(move |part| part.value.action.role() == role)
    }
}
