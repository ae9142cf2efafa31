//! Result of `fail … clear`, by the number of injected faults in each device before and after it. Where none has ended it is an error.

use miette::miette;

use super::FailArgs;

/// What `clear` has found in the devices, by the number of faults that held before and after it.
#[derive(Debug, Default)]
pub(super) struct Cleared {
    is_any: bool,
    /// Devices without a fault that was meant, each with the number of its others.
    unchanged: Vec<(String, u16)>,
}

impl Cleared {
    pub fn note(&mut self, device: &str, before: u16, after: u16) {
        if before == after {
            self.unchanged.push((device.to_owned(), after));
        } else {
            self.is_any = true;
        }
    }

    /// Why nothing was cleared, if nothing was.
    pub fn nothing(&self, args: &FailArgs) -> Option<miette::Report> {
        if self.is_any || self.unchanged.is_empty() {
            return None;
        }
        let devices: Vec<&str> = self.unchanged.iter().map(|(name, _)| name.as_str()).collect();
        let devices = devices.join(", ");
        let line = crate::out::shell_word(&args.line.display().to_string());
        let station = &args.station;
        let others = self.unchanged.iter().map(|(_, faults)| faults).sum::<u16>();
        let meant = match (&args.operation, &args.input) {
            (Some(operation), _) if args.recovery => format!("the recovery motion of `{operation}`"),
            (Some(operation), _) => format!("the motion of `{operation}`"),
            (None, Some(input)) => format!("input `{input}`"),
            (None, None) => {
                return Some(miette!(
                    help = format!("what {station} waits for: `linewright why {line} {station}`"),
                    "nothing to clear: no fault is injected in {devices}"
                ));
            }
        };
        let recovery =
            if args.operation.is_some() && !args.recovery { "; one of the way back has --recovery" } else { "" };
        let help = match others {
            0 => format!("no other fault is injected there{recovery}"),
            1 => format!("1 other fault is injected there: `linewright fail {line} {station} clear` ends it{recovery}"),
            others => format!(
                "{others} other faults are injected there: `linewright fail {line} {station} clear` ends all{recovery}"
            ),
        };
        Some(miette!(help = help, "nothing to clear: {meant} has no injected fault ({devices})"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::args;
    use super::*;
    use crate::can::injected::InjectedFault;

    #[test]
    fn a_clear_that_changes_nothing_says_so_and_names_what_else_holds() {
        let nothing = |args: &FailArgs, faults: &[(u16, u16)]| {
            let mut cleared = Cleared::default();
            faults.iter().for_each(|&(before, after)| cleared.note("clamp 1 io", before, after));
            cleared
                .nothing(args)
                .map(|why| (why.to_string(), why.help().map(|help| help.to_string()).unwrap_or_default()))
        };
        let all = args("clamp_1", InjectedFault::Clear);
        assert_eq!(nothing(&all, &[(0, 0), (1, 0)]), None, "one of two devices had a fault");
        let (text, help) = nothing(&all, &[(0, 0)]).expect("none had");
        assert_eq!(text, "nothing to clear: no fault is injected in clamp 1 io");
        assert!(help.contains("linewright why"), "{help}");
        let one = FailArgs { operation: Some("advance clamp".to_owned()), ..args("clamp_1", InjectedFault::Clear) };
        assert_eq!(nothing(&one, &[(2, 1)]), None);
        let (text, help) = nothing(&one, &[(2, 2)]).expect("not that one");
        assert_eq!(text, "nothing to clear: the motion of `advance clamp` has no injected fault (clamp 1 io)");
        assert!(help.starts_with("2 other faults are injected there") && help.ends_with("has --recovery"), "{help}");
    }
}
