//! `erard keyboard`.

use clap::Args;
use erard::instrument::Instrument;
use erard::keyboard::KEYS;
use erard_workshop::weighing::weigh;

use super::options::{KeyboardKey, load_keyboard};
use super::out::OutOptions;
use super::weigh::WeighOptions;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::keyboard::{doubts, pair, text, weighed_svg, write_csv};
use crate::progress::Progress;
use crate::say;
use crate::say::verbatim;
use crate::tell;

/// What stands below the options.
const AFTER: &str = "\
Writes keyboard.csv, and keyboard.svg and keyboard.png: hammers, leads and touch weights over the number of the key. The touch
weights are measured, key by key, in a slow loop with the dampers lifted. Every command takes a key of a keyboard as its
instrument: erard measure concert-grand:key=1 concert-grand:key=88. Every key is pressed once with a mezzo forte, too: the
hammer's speed, and whether the press can be trusted, are columns of the table.

Of two keyboards it writes keyboard-1.csv and keyboard-2.csv, difference.csv (the second less the first), keyboard.json with all three,
keyboard.svg and keyboard.png with both in every panel, and keyboard.html: the figure, and a row for every key.

With --weigh it works on a piano's own keys: writes weigh.html (the work list, to be printed), weigh.csv and weigh.json, and weigh.svg and
weigh.png. From BW + FW = KR WW + R SW (Stanwood 1996) come each key's ratio, friction and inertia; strike weights and ratios are smoothed
over the keyboard; and for each key stand the leads, the strike weight or the move of the capstan that alone would give the target. A sample
of keys is checked in the dynamic model.";

/// Weighs the keys of a keyboard from bass to treble, or writes one key's instrument, or balances a piano's keys.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Keyboard {
    /// Keyboard: a TOML file, or the name of a built-in one. Of two, the second is laid beside the first
    #[arg(id = "keyboard", value_name = "KEYBOARD", default_value = "concert-grand", num_args = 1..=2)]
    keyboards: Vec<String>,
    /// Weigh every so many keys, from the first to the last
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=87), allow_negative_numbers = true, conflicts_with = "key")]
    every: u8,
    /// Only print the instrument file of this key, 1 (A0) to 88 (C8), on standard output
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=88), allow_negative_numbers = true, conflicts_with_all = ["out", "force"])]
    key: Option<u8>,
    #[command(flatten)]
    weigh: WeighOptions,
    #[command(flatten)]
    out: OutOptions,
}

impl Keyboard {
    /// Runs the command.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        if let [first, second] = &self.keyboards[..] {
            return self.pair([first, second]);
        }
        let [keyboard] = &self.keyboards[..] else { return Err(Failure::Internal("no keyboard".into())) };
        let keyboard = load_keyboard(keyboard)?;
        if let Some(key) = self.key {
            let one = KeyboardKey { keyboard, key: usize::from(key) };
            verbatim(&format!("{}\n", one.text()?.trim_end_matches('\n')));
            return Ok(());
        }
        if let Some(path) = self.weigh.asked() {
            return self.weigh.run(path, &keyboard, &self.out);
        }
        let keys = self.keys(&keyboard)?;
        let mut output = self.out.prepare("keyboard", &["keyboard.csv", "keyboard.svg", "keyboard.png"])?;
        let mut progress = Progress::new("weighing");
        let weighed = weigh(&keys, &mut |share| progress.tell(share))
            .map_err(|error| Failure::Measure { label: keyboard.name.clone(), error })?;
        drop(progress);
        let svg = weighed_svg(&keyboard.name, &weighed);
        output.stage("keyboard.csv", |w| write_csv(&weighed, w))?;
        output.figure("keyboard", &svg)?;
        let written = output.commit()?;
        say!("{} - 88 keys, {} of them weighed", keyboard.name, weighed.len());
        say!();
        say!("{}", text(&weighed).trim_end_matches('\n'));
        for doubt in doubts(weighed.iter().map(|one| (one.key, &one.tried))) {
            tell!("warning: {doubt}");
        }
        say!();
        for path in written {
            say!("{}", shown(&path));
        }
        Ok(())
    }

    /// The keys that are weighed, with their numbers.
    fn keys(&self, keyboard: &erard::keyboard::Keyboard) -> Result<Vec<(usize, Instrument)>, Failure> {
        let mut numbers: Vec<usize> = (1..=KEYS).step_by(usize::from(self.every)).collect();
        if numbers.last() != Some(&KEYS) {
            numbers.push(KEYS);
        }
        numbers.into_iter().map(|key| Ok((key, keyboard.key(key)?))).collect()
    }

    /// Two keyboards beside each other.
    fn pair(&self, asked: [&String; 2]) -> Result<(), Failure> {
        if self.key.is_some() || self.weigh.asked().is_some() {
            return Err(Failure::Usage("--key and --weigh take one keyboard; two are laid beside each other".into()));
        }
        let keyboards = [load_keyboard(asked[0])?, load_keyboard(asked[1])?];
        let keys = [self.keys(&keyboards[0])?, self.keys(&keyboards[1])?];
        let mut output = self.out.prepare("keyboard", &pair::FILES)?;
        let mut progress = Progress::new("weighing");
        let mut weighed = |which: usize| {
            let mut tell = |share: f64| progress.tell(0.5 * (which as f64 + share));
            weigh(&keys[which], &mut tell)
                .map_err(|error| Failure::Measure { label: keyboards[which].name.clone(), error })
        };
        let weighed = [weighed(0)?, weighed(1)?];
        drop(progress);
        let mut names = pair::names([&keyboards[0].name, &keyboards[1].name]).into_iter();
        let sides = weighed.map(|weighed| pair::Side { name: names.next().unwrap_or_default(), weighed });
        pair::write(&sides, &mut output)?;
        let written = output.commit()?;
        say!("1: {}", sides[0].name);
        say!("2: {}", sides[1].name);
        say!("88 keys each, {} of them weighed", sides[0].weighed.len());
        say!();
        say!("{}", pair::text(&sides).trim_end_matches('\n'));
        for side in &sides {
            for doubt in doubts(side.weighed.iter().map(|one| (one.key, &one.tried))) {
                tell!("warning: {}: {doubt}", side.name);
            }
        }
        say!();
        for path in written {
            say!("{}", shown(&path));
        }
        Ok(())
    }
}
