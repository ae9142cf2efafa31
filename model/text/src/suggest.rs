//! "Did you mean …": the known name nearest to an unknown one.

use crate::NAME_MAX;

/// The candidate that `name` is most likely a slip of, if any is near enough.
///
/// Near enough is a third of the name's letters: enough for a swapped, missing or doubled one, too little for one word
/// to be taken for another. Case does not count, since a name in the wrong case is always worth a suggestion.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    nearest_all(name, candidates).first().copied()
}

/// All candidates that are equally near. Of those with as many letters that differ, one that goes on or ends earlier is nearer:
/// `of` is rather `off` than `on`.
pub(crate) fn nearest_all<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = name.to_lowercase();
    if wanted.len() > NAME_MAX {
        return Vec::new();
    }
    let limit = (wanted.chars().count() / 3).clamp(1, 4);
    let (mut best, mut found) = ((usize::MAX, true), Vec::new());
    for candidate in candidates {
        if candidate == name || !(1..=NAME_MAX).contains(&candidate.len()) {
            continue;
        }
        let known = candidate.to_lowercase();
        let rank = (distance(&wanted, &known), !known.starts_with(&wanted) && !wanted.starts_with(&known));
        if rank.0 > limit || rank > best || found.contains(&candidate) {
            continue;
        }
        if rank < best {
            (best, found) = (rank, Vec::new());
        }
        found.push(candidate);
    }
    found
}

/// Number of letters by which the names differ; a name cut short or written too long, such as one without its unit, is
/// near.
fn distance(wanted: &str, candidate: &str) -> usize {
    /// Shorter beginnings are shared by chance.
    const BEGINNING_MIN: usize = 4;
    let (short, long) = if wanted.len() < candidate.len() { (wanted, candidate) } else { (candidate, wanted) };
    if short.len() >= BEGINNING_MIN && long.starts_with(short) {
        return 1;
    }
    strsim::osa_distance(wanted, candidate)
}

/// The hint for an unknown name: the nearest known one, or else all of them where they are few.
pub fn suggestion<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str> + Clone) -> Option<String> {
    /// More than these are no help to read.
    const LISTED_MAX: usize = 12;
    /// More that are equally near are near by chance.
    const NEAREST_MAX: usize = 3;
    let near = nearest_all(name, candidates.clone());
    if !near.is_empty() {
        let near: Vec<String> = near.iter().take(NEAREST_MAX).map(|candidate| format!("`{candidate}`")).collect();
        let (last, others) = near.split_last()?;
        let others = others.iter().map(|name| format!("{name}, ")).collect::<String>();
        let others = others.strip_suffix(", ").map_or(String::new(), |others| format!("{others} or "));
        return Some(format!("did you mean {others}{last}?"));
    }
    let all: Vec<String> = candidates.into_iter().take(LISTED_MAX + 1).map(|c| format!("`{c}`")).collect();
    match all.len() {
        0 => None,
        n if n > LISTED_MAX => None,
        _ => Some(format!("known here: {}", all.join(", "))),
    }
}
