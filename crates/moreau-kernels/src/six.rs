//! Steps of six bodies in types of fixed size, with nothing around them, for benchmarks.

use moreau::{Input, Model, Outcome, Settings, State, Workspace, step};

/// Workspace of six bodies, fourteen zones and ten set-valued laws ([`crate::Size::Six`]).
pub type WorkspaceOfSix = Workspace<f64, 6, 14, 10>;

/// Calls [`moreau::step()`] once per input, for [`crate::Size::Six`]. Returns true if all numbers stayed finite, and
/// stops with false at the first step where one did not. The step is compiled into this loop, so that a benchmark
/// compiles none.
#[inline(never)]
pub fn steps_of_six(
    model: &Model<f64, 6, 14>,
    settings: &Settings<f64>,
    inputs: &mut dyn Iterator<Item = Input<f64>>,
    state: &mut State<f64, 6, 14>,
    workspace: &mut WorkspaceOfSix,
) -> bool {
    for input in inputs {
        if step(model, settings, &input, state, workspace).outcome == Outcome::NonFinite {
            return false;
        }
    }
    true
}
