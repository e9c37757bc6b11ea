//! MIDI ports of the operating system.

use std::string::{String, ToString};
use std::vec::Vec;

use midir::{MidiOutput, MidiOutputConnection};

/// The name under which this program appears.
const CLIENT: &str = "erard";

/// Why a port cannot be written to.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum PortError {
    /// The system's MIDI cannot be reached; with its message.
    System(String),
    /// No port, or more than one, has a name that contains the text; with the names of all ports.
    Name(Vec<String>),
}

impl std::fmt::Display for PortError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PortError::System(what) => write!(f, "the system's MIDI cannot be reached: {what}"),
            PortError::Name(ports) if ports.is_empty() => f.write_str("there are no MIDI ports"),
            PortError::Name(ports) => write!(f, "expected a name that belongs to one port of: {}", ports.join(", ")),
        }
    }
}

impl std::error::Error for PortError {}

fn system(error: impl ToString) -> PortError {
    PortError::System(error.to_string())
}

/// The names of the ports that can be written to.
///
/// # Errors
/// [`PortError::System`].
pub fn outputs() -> Result<Vec<String>, PortError> {
    let output = MidiOutput::new(CLIENT).map_err(system)?;
    output.ports().iter().map(|port| output.port_name(port).map_err(system)).collect()
}

/// A port that is written to.
pub struct Output(MidiOutputConnection);

impl Output {
    /// Opens the port whose name contains `name`.
    ///
    /// # Errors
    /// [`PortError`].
    pub fn open(name: &str) -> Result<Self, PortError> {
        let output = MidiOutput::new(CLIENT).map_err(system)?;
        let named: Vec<(String, _)> = output
            .ports()
            .into_iter()
            .map(|port| Ok((output.port_name(&port).map_err(system)?, port)))
            .collect::<Result<_, PortError>>()?;
        let mut those = named.iter().filter(|(own, _)| own.contains(name));
        let (Some((_, port)), None) = (those.next(), those.next()) else {
            return Err(PortError::Name(named.into_iter().map(|(own, _)| own).collect()));
        };
        Ok(Output(output.connect(port, CLIENT).map_err(system)?))
    }

    /// Sends bytes of MIDI 1.0 at once.
    ///
    /// # Errors
    /// [`PortError::System`].
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        self.0.send(bytes).map_err(system)
    }
}
