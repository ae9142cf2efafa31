//! Descriptions of what takes less time.

/// Durations are divided; time limits stay.
pub fn faster(text: &str, times: f64) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = ["duration_s = ", "time_s = "].iter().filter_map(|key| Some(rest.find(key)? + key.len())).min()
    {
        let (head, tail) = rest.split_at(at);
        let end = tail.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(tail.len());
        let seconds: f64 = tail[..end].parse().unwrap_or_else(|error| panic!("{error}: {:?}", &tail[..end]));
        out.push_str(head);
        out.push_str(&format!("{}", seconds / times));
        rest = &tail[end..];
    }
    out + rest
}
