//! Ranked causes of a key's faults, from any readings of it.
//!
//! `entry` lists the readings of a key, with names, precision and limits; `table` reads many keys from CSV; `bench`
//! holds the tests that distinguish places of friction. `cause` is the table of causes (`causes.toml`: frequency, quick
//! test, cure), `inject` puts a cause into a simulated action, `effect` holds the effect of each cause on each reading
//! (`effects.csv`, simulated on an ensemble), `healthy` the distribution of the readings of sound keys, `belief` the
//! probability of every cause and combination, `next` the most informative measurement, and `geometry` quantities
//! derived from weights. `beside` compares with neighbours, `report` assembles the answer, `answer` puts it into
//! sentences and JSON, and `typed` reads a form.

mod answer;
mod belief;
mod bench;
mod beside;
mod cause;
mod effect;
mod entry;
mod geometry;
mod healthy;
mod inject;
mod next;
mod normal;
mod report;
mod table;
mod typed;

pub use answer::{BASIS, Common, answer, common, explained_as, faults, form, joined};
pub use bench::{Bench, passes};
pub use cause::{Cause, Look, causes, looks};
pub use effect::{check_effects, effects_csv};
pub use entry::{Entry, Impossible, Known, entries, readings};
pub use geometry::{Band, Geometry};
pub use inject::{inject, inject_case, injected_amount};
pub use report::{Diagnosis, Judged, Ranked, Standing, Suggestion, WEIGH_AGAIN_G, diagnose, diagnose_all};
pub use table::{is_table_of_keys, read, unused_columns};
pub use typed::Typed;
