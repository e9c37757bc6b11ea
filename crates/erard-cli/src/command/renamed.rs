//! Options that have another name now. The error of an old name gives the new one.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Subcommand, option as it was called, and its name now.
const RENAMED: [(&str, &str, &str); 20] = [
    ("calibrate", "--law", "--sensor-law"),
    ("calibrate", "--out", "--out-file"),
    ("fit", "--most", "--max-evaluations"),
    ("fit", "--vary", "--parameters"),
    ("fmu", "--out", "--out-file"),
    ("keyboard", "--carry-out", "--simulate-work"),
    ("keyboard", "--leads", "--lead-masses"),
    ("keyboard", "--sample", "--checked-keys"),
    ("keyboard", "--weigh", "--measured"),
    ("live", "--bits", "--velocity-bits"),
    ("live", "--out", "--out-file"),
    ("live", "--port", "--midi-port"),
    ("man", "--into", "--out"),
    ("play", "--against", "--against-keyboard"),
    ("play", "--record-every", "--record-interval"),
    ("press", "--each", "--hand-per-variant"),
    ("regulate", "--out", "--out-file"),
    ("study", "--by", "--parameters"),
    ("study", "--each", "--hand-per-variant"),
    ("study", "--of", "--outcomes"),
];

/// Adds the name now to the error of an option that was renamed.
pub(super) fn name_renamed(error: &mut clap::Error, subcommand: Option<&str>) {
    let (ErrorKind::UnknownArgument, Some(ContextValue::String(found))) =
        (error.kind(), error.get(ContextKind::InvalidArg))
    else {
        return;
    };
    let Some((_, old, new)) = RENAMED.iter().find(|(of, old, _)| Some(*of) == subcommand && old == found) else {
        return;
    };
    error.remove(ContextKind::SuggestedArg);
    let tip = format!("`{old}` is called `{new}` now");
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::definition;

    /// The old name is no option, the new one is. The error gives the new name, and no other tip.
    #[test]
    fn the_error_gives_the_new_name() {
        for (subcommand, old, new) in RENAMED {
            let mut definition = definition();
            definition.build();
            let has = |option: &str| {
                let of = definition.find_subcommand(subcommand).expect("a subcommand");
                of.get_arguments().any(|one| {
                    let names = one.get_long_and_visible_aliases().unwrap_or_default();
                    names.iter().any(|name| Some(*name) == option.strip_prefix("--"))
                })
            };
            assert!(!has(old) && has(new), "{subcommand} {old} {new}");
            for typed in [vec![old.to_owned()], vec![old.to_owned(), "1".to_owned()], vec![format!("{old}=1")]] {
                let arguments = ["erard", subcommand].map(str::to_owned).into_iter().chain(typed.clone());
                let mut error = super::super::definition().try_get_matches_from(arguments).unwrap_err();
                name_renamed(&mut error, Some(subcommand));
                let told = error.to_string();
                let tip = format!("tip: `{old}` is called `{new}` now");
                assert!(told.contains(&tip) && told.matches("tip:").count() == 1, "{typed:?}: {told}");
                assert_eq!(error.exit_code(), 2);
            }
        }
    }
}
