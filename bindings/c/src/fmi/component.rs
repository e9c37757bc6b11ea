//! An instance of the unit: its variables, clock and states.

use std::collections::HashMap;
use std::ffi::{CString, c_int, c_void};

use erard::player::SNAPSHOT_MARK;
use erard::saved::{Lists, Writer};
use erard_workshop::fmu::{Role, Unit, Variable};

use super::played::{Instant, Played};
use super::{DISCARD, Done, Logger, OK, WARNING, log};
use crate::keyboard;
use crate::reading::{
    ERARD_INPUT_FORCE, ERARD_INPUT_FREE, ERARD_INPUT_HAND, ERARD_INPUT_MOTION, ERARD_INPUT_RIGID, ErardInput,
};
use crate::status::ErardStatus;

/// Most steps of the simulation in one communication step.
const MAX_STEPS: u64 = 10_000_000;

/// A saved state: action or keyboard, inputs, start and steps.
pub(super) type SavedState = Vec<u8>;
/// Name of the inputs in it.
const INPUTS: &str = "fmu_inputs";

/// An instance of the unit.
pub(crate) struct Component {
    name: CString,
    logger: Logger,
    environment: *mut c_void,
    unit: Unit,
    /// Indices of the variables, by whether they are integers, and by reference.
    places: HashMap<(bool, u32), usize>,
    /// Present values of inputs and parameters, by index.
    values: Vec<f64>,
    /// Indices of the force, position, velocity and drive of each key.
    drivers: Vec<[usize; 4]>,
    /// Exists from the end of initialisation.
    played: Option<Played>,
    start_s: f64,
    /// Steps taken since then.
    steps: u64,
}

/// Start values.
fn first(variables: &[Variable]) -> Vec<f64> {
    variables.iter().map(|variable| variable.start.unwrap_or(0.0)).collect()
}

impl Component {
    pub(super) fn new(unit: Unit, name: CString, logger: Logger, environment: *mut c_void) -> Self {
        let all = || unit.variables.iter().enumerate();
        let of = |role: Role| all().filter(move |(_, variable)| variable.role == role).map(|(place, _)| place);
        let [force, position, velocity, drive] = [Role::Force, Role::Position, Role::Velocity, Role::Drive].map(of);
        let drivers = force.zip(position).zip(velocity).zip(drive).map(|(((a, b), c), d)| [a, b, c, d]).collect();
        Component {
            name,
            logger,
            environment,
            places: all().map(|(place, one)| ((one.is_integer(), one.reference), place)).collect(),
            values: first(&unit.variables),
            drivers,
            unit,
            played: None,
            start_s: 0.0,
            steps: 0,
        }
    }

    pub(super) fn log(&self, status: c_int, text: &str) {
        log(self.logger, self.environment, &self.name, status, text);
    }

    pub(super) fn variable(&self, reference: u32, is_integer: bool) -> Result<usize, String> {
        let found = self.places.get(&(is_integer, reference)).copied();
        found.ok_or_else(|| format!("there is no variable of value reference {reference}"))
    }

    pub(super) fn get(&self, place: usize) -> f64 {
        let Variable { role, key, start, .. } = self.unit.variables[place];
        let Some(played) = self.played.as_ref().filter(|_| start.is_none()) else { return self.values[place] };
        let key = key.unwrap_or(1);
        match role {
            Role::BridgeSum => played.bridge_sum_n(),
            Role::Awake => played.awake() as f64,
            Role::Contact(zone) => played.contact_force(zone),
            Role::Impacts => f64::from(played.reading(key).impact_count),
            Role::Reading(n) => {
                let r = played.reading(key);
                [
                    r.key_m,
                    r.key_m_per_s,
                    r.finger_force_n,
                    r.hammer_rise_m,
                    r.hammer_rise_m_per_s,
                    r.string_n,
                    if r.impact_count > 0 { self.start_s + r.impact_time_s } else { 0.0 },
                    r.hammer_speed_m_per_s,
                    played.bridge_n(key),
                    r.hand_m,
                    r.hand_m_per_s,
                ][n]
            }
            _ => self.values[place],
        }
    }

    pub(super) fn set(&mut self, place: usize, value: f64) -> Result<(), String> {
        let variable = &self.unit.variables[place];
        let Variable { name, .. } = variable;
        if !value.is_finite() {
            return Err(format!("`{name}` cannot be {value}"));
        }
        if variable.start.is_none() {
            return Err(format!("`{name}` is an output: it cannot be set"));
        }
        if variable.is_parameter() && self.played.is_some() {
            return Err(format!("`{name}` is a parameter: it can be set before the end of initialisation only"));
        }
        self.values[place] = value;
        Ok(())
    }

    /// Value of a variable of the whole unit.
    fn value(&self, role: Role) -> f64 {
        self.unit.variables.iter().zip(&self.values).find(|(v, _)| v.role == role).map_or(0.0, |(_, value)| *value)
    }

    /// Returns the present input of each key.
    fn inputs(&self) -> Result<Vec<ErardInput>, String> {
        let of_hand =
            [Role::HandMass, Role::MuscleStiffness, Role::MuscleDamping, Role::JointsCompliance, Role::JointsTime];
        let [hand_mass_kg, muscle_n_per_m, muscle_n_s_per_m, joints_m_per_n, joints_s] =
            of_hand.map(|role| self.value(role));
        let input = |[force, position, velocity, drive]: &[usize; 4]| {
            let kind = match self.values[*drive] {
                0.0 => ERARD_INPUT_FREE,
                1.0 => ERARD_INPUT_FORCE,
                2.0 => ERARD_INPUT_MOTION,
                3.0 => ERARD_INPUT_RIGID,
                4.0 => ERARD_INPUT_HAND,
                other => {
                    let Variable { name, .. } = &self.unit.variables[*drive];
                    return Err(format!("`{name}` is {other}; expected 0, 1, 2, 3 or 4"));
                }
            };
            Ok(ErardInput {
                kind,
                force_n: self.values[*force],
                position_m: self.values[*position],
                velocity_m_per_s: self.values[*velocity],
                hand_mass_kg,
                muscle_n_per_m,
                muscle_n_s_per_m,
                joints_m_per_n,
                joints_s,
                ..ErardInput::default()
            })
        };
        self.drivers.iter().map(input).collect()
    }

    /// Sets the start of the experiment, on the importer's clock, s.
    pub(super) fn begin_at(&mut self, start_s: f64) {
        self.start_s = start_s;
    }

    /// Makes the action or keyboard with its parameters, at rest.
    pub(super) fn begin(&mut self) -> Result<(), String> {
        self.inputs()?;
        let instruments = self.unit.instruments(&self.values)?;
        let played = Played::at_rest(&instruments, self.unit.is_keyboard(), self.value(Role::Step));
        (self.played, self.steps) = (Some(played.map_err(|fault| fault.text)?), 0);
        Ok(())
    }

    /// Returns to the state after instantiation.
    pub(super) fn reset(&mut self) {
        (self.played, self.start_s, self.steps) = (None, 0.0, 0);
        self.values = first(&self.unit.variables);
    }

    /// Takes a communication step.
    pub(super) fn step(&mut self, now_s: f64, length_s: f64) -> Done {
        let inputs = self.inputs()?;
        let (step_s, pedal_m) = (self.value(Role::Step), self.value(Role::Pedal));
        let Component { played: Some(played), start_s, steps, .. } = self else {
            return Err("a step before the end of initialisation".into());
        };
        let until = (now_s + length_s - *start_s) / step_s;
        if !(length_s >= 0.0 && until.is_finite() && until > -0.5 && until - *steps as f64 <= MAX_STEPS as f64) {
            return Err(format!("a communication step of {length_s} s at {now_s} s"));
        }
        // Whole steps, counted from the start.
        let until = until.round() as u64;
        played.set_pedal(pedal_m);
        let (mut worst, mut is_first) = (OK, true);
        while *steps < until {
            // Moving inputs continue within the communication step.
            let at = Instant { start_s: *start_s, now_s, step_s, steps: *steps, is_first };
            match played.step(&inputs, at) {
                Ok(ErardStatus::Ok) => {}
                Ok(ErardStatus::IterationLimit) => worst = WARNING,
                Ok(ErardStatus::NotFinite) => {
                    self.log(DISCARD, "a number became infinite");
                    return Ok(DISCARD);
                }
                Ok(status) => return Err(format!("a step could not be taken: {status:?}")),
                Err(text) => return Err(text),
            }
            *steps += 1;
            is_first = false;
        }
        Ok(worst)
    }

    /// Returns the bytes with which saved states of this unit begin.
    pub(super) fn mark(&self) -> [u8; 8] {
        if self.unit.is_keyboard() { keyboard::MARK } else { SNAPSHOT_MARK }
    }

    /// Returns the size of a state in bytes.
    pub(super) fn state_bytes(&self) -> Result<usize, String> {
        self.write(&mut [])
    }

    fn write(&self, bytes: &mut [u8]) -> Result<usize, String> {
        let played = self.played.as_ref().ok_or("there is no state before the end of initialisation")?;
        let mut out = Writer::new(bytes, self.mark());
        played.write(&mut out);
        let inputs = self.unit.variables.iter().zip(&self.values).filter(|(variable, _)| variable.is_input());
        out.list(INPUTS, &mut inputs.map(|(_, value)| *value));
        out.number("fmu_start_s", self.start_s);
        out.word("fmu_steps", self.steps);
        Ok(out.seal())
    }

    pub(super) fn save(&self) -> Result<SavedState, String> {
        let mut state = vec![0; self.state_bytes()?];
        self.write(&mut state)?;
        Ok(state)
    }

    pub(super) fn restore(&mut self, state: &SavedState) -> Result<(), String> {
        let mark = self.mark();
        let played = self.played.as_mut().ok_or("a state can be set after the end of initialisation only")?;
        let lists = Lists::read(state, mark).map_err(|error| error.to_string())?;
        let status = played.read(&lists);
        if status != ErardStatus::Ok {
            return Err(format!("the state belongs to another instance: {status:?}"));
        }
        let places: Vec<usize> = (0..self.values.len()).filter(|n| self.unit.variables[*n].is_input()).collect();
        // A state of the library alone has no inputs: they take their start values.
        let mut inputs: Vec<f64> =
            places.iter().map(|place| self.unit.variables[*place].start.unwrap_or(0.0)).collect();
        lists.fill(INPUTS, &mut inputs);
        for (place, value) in places.into_iter().zip(inputs) {
            self.values[place] = value;
        }
        self.start_s = lists.number("fmu_start_s").unwrap_or(0.0);
        self.steps = lists.word("fmu_steps").unwrap_or(0);
        Ok(())
    }
}
