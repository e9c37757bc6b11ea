//! Causes of a key's faults, ranked, from whatever was measured of it.
//!
//! `entry` lists what can be read off a key, with the words for it, the precision of a reading and what is impossible;
//! `table` reads many keys from CSV; `bench` holds the tests that tell places of friction apart. `cause` is the table
//! of causes (`causes.toml`: how common, quick test, remedy), `plant` puts a cause into a simulated action, `effect`
//! what each cause does to each reading (`effects.csv`, simulated on an ensemble), `healthy` how readings of sound keys
//! lie, `belief` the probability of every cause and combination, `next` the measurement that would tell most, and
//! `geometry` what follows from weights. `report` draws the answer together, `answer` says it in sentences and as JSON,
//! and `typed` takes the readings of a form.

mod answer;
mod belief;
mod bench;
mod cause;
mod effect;
mod entry;
mod geometry;
mod healthy;
mod next;
mod plant;
mod report;
mod spd;
mod table;
mod typed;

pub use answer::{BASIS, answer, explained_as, faults, form, joined};
pub use bench::{Bench, passes};
pub use cause::{Cause, causes};
pub use effect::{check_effects, effects_csv};
pub use entry::{Entry, Impossible, Known, entries};
pub use geometry::{Band, Geometry};
pub use plant::{plant, plant_amount};
pub use report::{Diagnosis, Judged, Ranked, Standing, Suggestion, diagnose};
pub use table::{is_table_of_keys, read};
pub use typed::Typed;
