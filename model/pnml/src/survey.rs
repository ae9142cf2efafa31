//! Is this PNML, and which nets are in it? One pass over the whole file before any net is read.
//!
//! It costs little and makes the rest simple: what is read afterwards is known to be XML to its end, and a file of
//! several nets is not read half.

use crate::xml::{Xml, XmlAbort};
use linewright_diagnostics::{At, Problem, Report, shown};

/// The most nets in one file.
const NETS_MAX: usize = 10_000;

/// Number of ids named in the advice on a file of several nets.
const NAMED_MAX: usize = 8;

/// The position, among the nets of the file, of the one to read.
pub(crate) fn choose(text: &str, wanted: Option<&str>, report: &mut Report) -> Option<usize> {
    let nets = survey(text, report).ok()?;
    let named = || {
        let more = if nets.len() > NAMED_MAX { ", …" } else { "" };
        let ids: Vec<_> = nets.iter().take(NAMED_MAX).map(|(id, _)| format!("`{}`", shown(id))).collect();
        format!("{}{more}", ids.join(", "))
    };
    let (_, second) = nets.get(1).unwrap_or(nets.first()?);
    let finding = match (wanted, nets.len()) {
        (None, 1) => return Some(0),
        (None, count) => Problem::error(*second, format!("the file has {count} nets: {}", named()))
            .hint("select one with `--net ID`"),
        (Some(wanted), _) => match nets.iter().filter(|(id, _)| id == wanted).count() {
            1 => return nets.iter().position(|(id, _)| id == wanted),
            0 => Problem::error(nets[0].1, format!("no net of this file has the id `{}`", shown(wanted)))
                .hint(format!("there is {}", named())),
            count => Problem::error(*second, format!("{count} nets of this file have the id `{}`", shown(wanted)))
                .hint("ids are unique in a file"),
        },
    };
    report.add(finding);
    None
}

/// The ids of all nets, empty where there is none, and where they are. Reports if there is no net at all.
fn survey(text: &str, report: &mut Report) -> Result<Vec<(String, At)>, XmlAbort> {
    let mut xml = Xml::new(text);
    let Some(root) = xml.child(report)? else {
        let finding = Problem::error(At::default(), "there is no XML element in this file");
        report.add(finding.hint("is this the right file?"));
        return Err(XmlAbort);
    };
    if root.name != "pnml" {
        let finding = Problem::error(root.at, format!("the outermost element is `{}`, not `pnml`", shown(root.name)));
        report.add(finding.hint("only PNML is read; is this the right file?"));
        return Err(XmlAbort);
    }
    let mut nets = Vec::new();
    while let Some(tag) = xml.child(report)? {
        if tag.name == "net" {
            if nets.len() == NETS_MAX {
                report.add(Problem::error(tag.at, format!("the file has more than {NETS_MAX} nets")));
                return Err(XmlAbort);
            }
            let [id] = tag.attributes(&xml, ["id"], &mut Report::of_excerpts());
            nets.push((id.map(|id| id.text.into_owned()).unwrap_or_default(), tag.at));
        }
        xml.skip(report)?;
    }
    // Behind the outermost element there is nothing, or that is reported.
    xml.child(report)?;
    if nets.is_empty() {
        report.add(
            Problem::error(root.at, "there is no net in this file").hint("a net is an element `<net>` in `<pnml>`"),
        );
        return Err(XmlAbort);
    }
    Ok(nets)
}
