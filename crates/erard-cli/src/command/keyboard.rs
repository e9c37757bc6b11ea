//! `erard keyboard`.

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::Base;
use erard::keyboard::KEYS;
use erard_workshop::weighing::weigh;

use super::options::key;
use super::out::OutOptions;
use super::weigh::WeighOptions;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::{KeyboardKey, load_keyboard};
use crate::keyboard::{headlines, pair, table, text, warnings, weighed_picture};
use crate::number::whole;
use crate::print_line;
use crate::session::Session;
use crate::warn;

/// Text below the options.
const AFTER: &str = include_str!("help/keyboard.txt");

/// Weighs the keys of a keyboard from bass to treble, prints one key's instrument file, or balances the keys of a real
/// piano.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Keyboard {
    /// Keyboard: a TOML file, or a built-in name. Two keyboards are compared
    #[arg(id = "keyboard", value_name = "KEYBOARD", default_value = "concert-grand", num_args = 1..=2)]
    keyboards: Vec<Base>,
    /// Weigh every N-th key
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = whole::<u8>(1, 87), allow_negative_numbers = true, conflicts_with = "key")]
    every: u8,
    /// Only print the instrument file of this key, by number or note (40, C4)
    #[arg(long, value_name = "KEY", value_parser = key, allow_negative_numbers = true, conflicts_with_all = ["out", "force"])]
    key: Option<usize>,
    #[command(flatten)]
    weigh: WeighOptions,
    #[command(flatten)]
    out: OutOptions,
}

impl Keyboard {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if let [first, second] = &self.keyboards[..] {
            return self.pair(session, [first, second]);
        }
        let [keyboard] = &self.keyboards[..] else { return Err(Failure::Internal("no keyboard".into())) };
        let keyboard = load_keyboard(session, keyboard)?;
        if let Some(key) = self.key {
            let one = KeyboardKey { keyboard, key };
            return Ok(Answer::text(format!("{}\n", one.text()?.trim_end_matches('\n'))));
        }
        if let Some(path) = self.weigh.asked() {
            return self.weigh.run(session, path, &keyboard, &self.out);
        }
        let keys = self.keys(&keyboard)?;
        let mut output = self.out.prepare(session, "keyboard", &["keyboard.csv", "keyboard.svg", "keyboard.png"])?;
        let mut progress = session.progress("weighing");
        let weighed = weigh(&keys, &mut |share| progress.tell(share))
            .map_err(|error| Failure::Measure { label: keyboard.name.clone(), error: Box::new(error) })?;
        drop(progress);
        let picture = weighed_picture(&keyboard.name, &weighed);
        let table = table(&weighed);
        output.table(session, "keyboard.csv", &table)?;
        output.figure(session, "keyboard", &picture)?;
        let written = output.commit(session)?;
        print_line!(session, "{} - 88 keys, {} of them weighed", keyboard.name, weighed.len());
        print_line!(session);
        headlines(&weighed).into_iter().for_each(|line| print_line!(session, "{line}"));
        session.printer.begin_rest("a table of keys from bass to treble");
        print_line!(session, "{}", text(&weighed).trim_end_matches('\n'));
        let doubts = warnings(&weighed);
        for doubt in &doubts {
            warn!(session, "warning: {doubt}");
        }
        print_line!(session);
        let answer = Answer::table(session, Some(&table)).with("keyboard", &keyboard.name)?;
        Ok(answer.with("warnings", &doubts)?.end(session, &written))
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
    fn pair(&self, session: &mut Session, asked: [&Base; 2]) -> Result<Answer, Failure> {
        if self.key.is_some() || self.weigh.asked().is_some() {
            return Err(Failure::Usage("--key and --measured need one keyboard; found two".into()));
        }
        let keyboards = [load_keyboard(session, asked[0])?, load_keyboard(session, asked[1])?];
        let keys = [self.keys(&keyboards[0])?, self.keys(&keyboards[1])?];
        let mut output = self.out.prepare(session, "keyboard", &pair::FILES)?;
        let mut progress = session.progress("weighing");
        let mut weighed = |which: usize| {
            let mut tell = |share: f64| progress.tell(0.5 * (which as f64 + share));
            weigh(&keys[which], &mut tell)
                .map_err(|error| Failure::Measure { label: keyboards[which].name.clone(), error: Box::new(error) })
        };
        let weighed = [weighed(0)?, weighed(1)?];
        drop(progress);
        let mut names = pair::names([&keyboards[0].name, &keyboards[1].name]).into_iter();
        let sides = weighed.map(|weighed| pair::Side { name: names.next().unwrap_or_default(), weighed });
        let report = pair::write(session, &sides, &mut output)?;
        let written = output.commit(session)?;
        print_line!(session, "1: {}", sides[0].name);
        print_line!(session, "2: {}", sides[1].name);
        print_line!(session, "88 keys each, {} of them weighed", sides[0].weighed.len());
        print_line!(session);
        pair::headlines(&sides).into_iter().for_each(|line| print_line!(session, "{line}"));
        session.printer.begin_rest("a table of keys from bass to treble");
        print_line!(session, "{}", pair::text(&sides).trim_end_matches('\n'));
        let mut all = Vec::new();
        for side in &sides {
            all.extend(warnings(&side.weighed).iter().map(|doubt| format!("{}: {doubt}", side.name)));
        }
        for warning in &all {
            warn!(session, "warning: {warning}");
        }
        print_line!(session);
        Ok(Answer::of(&report)?.with("warnings", &all)?.end(session, &written))
    }
}
