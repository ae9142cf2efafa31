//! "Did you mean …": the known name nearest to an unknown one.

use crate::NAME_MAX;

/// The candidate that `name` is most likely a slip of, if any is near enough.
///
/// Near enough is a third of the name's letters: enough for a swapped, missing or doubled one, too little for one word
/// to be taken for another. Case does not count, since a name in the wrong case is always worth a suggestion.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    if wanted.len() > NAME_MAX {
        return None;
    }
    let limit = (wanted.chars().count() / 3).clamp(1, 4);
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name && (1..=NAME_MAX).contains(&candidate.len()))
        .map(|candidate| (distance(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|&(distance, _)| distance <= limit)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
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
    if let Some(candidate) = nearest(name, candidates.clone()) {
        return Some(format!("did you mean `{candidate}`?"));
    }
    let all: Vec<String> = candidates.into_iter().take(LISTED_MAX + 1).map(|c| format!("`{c}`")).collect();
    match all.len() {
        0 => None,
        n if n > LISTED_MAX => None,
        _ => Some(format!("known here: {}", all.join(", "))),
    }
}
