//! `--parts`: how many parts of which types.
//!
//! The rule for every option that takes a list of names: it may be repeated, and names may contain commas. Where several stand in
//! one argument, a comma separates only behind a number.

/// A number of cycles, states or the like: none of them would be nothing to do.
///
/// # Errors
/// What is expected, where it is something else.
pub fn at_least_1(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| *number > 0);
    number.ok_or_else(|| "expected a whole number, 1 or more, without a unit".to_owned())
}

/// More parts are no more informative.
pub const PARTS_MAX: u32 = 100_000;

/// One argument: part types with their numbers, e.g. `A=3,B=2`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartList(Vec<(String, u32)>);

impl PartList {
    /// Reads one argument.
    ///
    /// # Errors
    /// The first item that is not `TYPE=NUMBER`, or has more than [`PARTS_MAX`] parts.
    pub fn read(text: &str) -> Result<Self, String> {
        let mut parts = Vec::new();
        let mut rest = text;
        loop {
            // The name of the next one may contain commas: it ends with the first `=NUMBER` behind which the text ends or a comma
            // stands.
            let ends = rest.match_indices(',').map(|(at, _)| at).chain([rest.len()]);
            let next = ends.map(|end| (end, part(&rest[..end]))).find(|(_, read)| read.is_ok());
            let (end, read) = next.unwrap_or_else(|| (rest.len(), part(rest)));
            parts.push(read?);
            rest = rest[end..].trim_start_matches(',');
            if rest.is_empty() {
                return Ok(PartList(parts));
            }
        }
    }

    /// All arguments together; each type once, in the order in which they are named.
    pub fn sum(lists: &[PartList]) -> Vec<(String, u32)> {
        let mut all: Vec<(String, u32)> = Vec::new();
        for (name, count) in lists.iter().flat_map(|list| &list.0) {
            match all.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum = sum.saturating_add(*count),
                None => all.push((name.clone(), *count)),
            }
        }
        all
    }
}

/// So many parts of a type, as `A=3`.
fn part(text: &str) -> Result<(String, u32), String> {
    let (name, count) =
        text.rsplit_once('=').ok_or_else(|| format!("`{text}` is not as in `A=3`: write TYPE=NUMBER"))?;
    let (name, count) = (name.trim(), count.trim());
    let count: u32 = count.parse().map_err(|_| format!("`{count}` is not a number of parts"))?;
    if count <= PARTS_MAX { Ok((name.to_owned(), count)) } else { Err(format!("at most {PARTS_MAX} parts")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(arguments: &[&str]) -> Result<Vec<(String, u32)>, String> {
        let lists: Result<Vec<PartList>, String> = arguments.iter().map(|text| PartList::read(text)).collect();
        Ok(PartList::sum(&lists?))
    }

    fn are(arguments: &[&str], expected: &[(&str, u32)]) {
        let expected = expected.iter().map(|&(name, count)| (name.to_owned(), count)).collect();
        assert_eq!(read(arguments), Ok(expected), "{arguments:?}");
    }

    #[test]
    fn names_may_contain_commas_and_the_option_may_be_repeated() {
        are(&["A=3,B=2"], &[("A", 3), ("B", 2)]);
        are(&["A=3", "B=2", "A=1"], &[("A", 4), ("B", 2)]);
        are(&["bolt, M8=3"], &[("bolt, M8", 3)]);
        are(&["bolt, M8=3,nut, M8=4"], &[("bolt, M8", 3), ("nut, M8", 4)]);
        are(&["x=y,z=1"], &[("x=y,z", 1)]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert_eq!(read(&["A"]), Err("`A` is not as in `A=3`: write TYPE=NUMBER".to_owned()));
        assert_eq!(read(&["A=1,B"]), Err("`B` is not as in `A=3`: write TYPE=NUMBER".to_owned()));
        assert_eq!(read(&["A=x"]), Err("`x` is not a number of parts".to_owned()));
        assert_eq!(read(&["A=100001"]), Err("at most 100000 parts".to_owned()));
        assert!(read(&[""]).is_err());
    }
}
