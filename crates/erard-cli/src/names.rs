//! Options that take one of a few names.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use erard::parameter::{aliases, canonical_name};

/// A name on the command line, what the help says of it, and the value it represents.
pub(crate) type Name<T> = (&'static str, &'static str, T);

/// Takes one of a few names, with the words of any region.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(
    names: &'static [Name<T>],
) -> impl TypedValueParser<Value = T> + use<T> {
    let values = names.iter().map(|(name, help, _)| PossibleValue::new(*name).help(*help).aliases(aliases(name)));
    let meant =
        |given: String| names.iter().find(|(name, ..)| *name == canonical_name(&given)).expect("only names pass").2;
    PossibleValuesParser::new(values).map(meant)
}
