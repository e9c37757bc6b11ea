//! A technician who reads with an error, and turns with an error.

use erard::instrument::Instrument;
use erard_workshop::worklist::{Item, ReadingQuantity, Readings, Why, Work, Worklist};

/// Key whose usual ranges hold.
pub const KEY: usize = 40;
/// Most turns of one screw, or bends of one wire.
const TURNS: usize = 8;
/// Most steps of one bend of a wire or a spring: they are bent little by little, and the hammer is tried between.
const LITTLE: f64 = 2.0;
/// Blow that an eighth of a turn of the capstan takes at least, mm.
const EIGHTH_MM: f64 = 1.3;

/// Random numbers, the same every time (Vigna's splitmix64).
pub struct Chance(u64);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Chance(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5dee_ce66)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Number from 0 to 1.
    pub fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Number from -1 to 1.
    pub fn either_way(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    pub fn happens(&mut self, share: f64) -> bool {
        self.share() < share
    }
}

/// Readings of the truth, each off by up to its precision.
pub fn seen(truth: &Readings, chance: &mut Chance) -> Readings {
    let mut seen = *truth;
    for quantity in ReadingQuantity::ALL {
        seen.set(quantity, truth.get(quantity).map(|value| value + quantity.precision() * chance.either_way()));
    }
    seen
}

/// A line as a hand has carried it out.
pub struct Done {
    /// The turns, one by one.
    pub works: Vec<Work>,
    /// Whether a check's wire was bent back, because the check caught the hammer no farther out.
    pub caught_no_farther: bool,
}

/// Carries out a line as the sheet says it. `truth` are the piano's own readings.
///
/// Screws, paper and wires are turned, laid and bent until the line reads what the sheet promises, or well inside its
/// range, each time by whole steps and off by up to half of one; a line that cannot be read is done once, blind, and so
/// are hammers. Friction is eased, and leads lying on the key are shifted, until the weights on the key read the whole
/// grams on the sheet, but no farther than it allows.
pub fn by_hand(
    item: &Item,
    can_be_read: bool,
    piano: &mut Instrument,
    truth: &mut Readings,
    front_mm: f64,
    chance: &mut Chance,
) -> Done {
    let go_on = &mut |_: f64| true;
    let (mut works, mut turning) = (Vec::new(), Turning::new(item, seen(truth, chance).get(item.quantity)));
    let mut planned = if can_be_read { turning.first() } else { Some(item.work.clone()) };
    while let Some(work) = planned.take() {
        let read = seen(truth, chance);
        let amount = match (&work, item.weighed_g()) {
            (Work::Friction { by_g }, Some([down_g, up_g])) => {
                let left_g =
                    read.get(ReadingQuantity::FrictionWeight).map_or(*by_g, |read| 0.5 * (down_g - up_g) - read);
                // What is eased too far stays so.
                if by_g.is_sign_negative() { left_g.min(0.0) } else { left_g.max(0.0) }
            }
            (Work::Leads(leads), Some([down_g, up_g])) if !leads.put.is_empty() => {
                let mass_g: f64 = leads.put.iter().map(|lead| lead.mass_g).sum();
                let most_mm = item.room_to_shift_mm(KEY, front_mm).unwrap_or(f64::INFINITY);
                let wanted_g = read.get(ReadingQuantity::BalanceWeight).map(|read| read - 0.5 * (down_g + up_g));
                wanted_g.unwrap_or(work.amount()).min(work.amount() + most_mm * mass_g / front_mm)
            }
            _ => work.amount() + 0.5 * work.step() * chance.either_way(),
        };
        let work = work.with_amount(amount, front_mm);
        work.carry_out(piano, go_on).unwrap();
        *truth = Readings::of(piano, go_on).unwrap();
        if can_be_read && works.len() + 1 < TURNS {
            planned = turning.next(amount, seen(truth, chance).get(item.quantity));
        }
        works.push(work);
    }
    Done { works, caught_no_farther: turning.is_back && item.quantity == ReadingQuantity::Check }
}

/// Lines with their screws, in the order of work, and whether a larger setting makes the reading larger.
const SCREWS: [(ReadingQuantity, &str, f64); 9] = [
    (ReadingQuantity::Dip, "front_punching", -1.0),
    (ReadingQuantity::Blow, "capstan_height", -1.0),
    (ReadingQuantity::JackPosition, "jack_position", 1.0),
    (ReadingQuantity::LeverHeight, "lever_height", 1.0),
    (ReadingQuantity::LetOff, "let_off", -1.0),
    (ReadingQuantity::Drop, "drop", 1.0),
    (ReadingQuantity::Check, "back_check", -1.0),
    (ReadingQuantity::Spring, "repetition_spring", 1.0),
    (ReadingQuantity::Damper, "damper_timing", -1.0),
];

/// Reads the screws' lines once more after the last of them, as the sheet says, and sets what is out of its range: a
/// line of the list as before, another one step by step with its own screw, unless the list says why it stays out.
/// Returns whether the check catches the hammer no farther out.
pub fn read_once_more(
    list: &Worklist,
    piano: &mut Instrument,
    truth: &mut Readings,
    front_mm: f64,
    chance: &mut Chance,
) -> bool {
    let go_on = &mut |_: f64| true;
    let mut caught_no_farther = false;
    // Twice: let-off and drop move each other.
    for (quantity, name, sense) in SCREWS.into_iter().chain(SCREWS) {
        let is_own = |item: &&Item| item.quantity == quantity && matches!(item.work, Work::Screw { .. });
        if let Some(item) = list.items.iter().find(is_own) {
            if seen(truth, chance).is_out(quantity, KEY) {
                caught_no_farther |= by_hand(item, true, piano, truth, front_mm, chance).caught_no_farther;
            }
        } else if !list.left.iter().any(|left| left.quantity == quantity && left.why != Why::ReadAgain) {
            for _ in 0..TURNS {
                let Some(read) = seen(truth, chance).get(quantity) else { break };
                let [low, high] = quantity.line().range(KEY);
                let way = if low.is_some_and(|low| read < low) {
                    1.0
                } else if high.is_some_and(|high| read > high) {
                    -1.0
                } else {
                    break;
                };
                let step = Work::Screw { name, by: 0.0 };
                let by = (way * sense + 0.5 * chance.either_way()) * step.step();
                step.with_amount(by, 0.0).carry_out(piano, go_on).unwrap();
                *truth = Readings::of(piano, go_on).unwrap();
            }
        }
        if quantity == ReadingQuantity::Drop && list.aftertouch_is_decided_by().is_some() {
            correct_aftertouch(piano, truth, chance);
        }
    }
    caught_no_farther
}

/// Brings the aftertouch into its range by paper, as far as the dip allows, then by the capstan, as far as the blow
/// does.
pub fn correct_aftertouch(piano: &mut Instrument, truth: &mut Readings, chance: &mut Chance) {
    let go_on = &mut |_: f64| true;
    for _ in 0..TURNS {
        let read = seen(truth, chance);
        let (Some(aftertouch), Some(dip), Some(blow)) =
            (read.get(ReadingQuantity::Aftertouch), read.get(ReadingQuantity::Dip), read.get(ReadingQuantity::Blow))
        else {
            return;
        };
        let range = |quantity: ReadingQuantity| quantity.line().range(KEY).map(Option::unwrap);
        let [low, high] = range(ReadingQuantity::Aftertouch);
        let too_much = (aftertouch - high).max(0.0) - (low - aftertouch).max(0.0);
        let [shallowest, deepest] = range(ReadingQuantity::Dip);
        let [nearest, farthest] = range(ReadingQuantity::Blow);
        let (dip_room, blow_room) =
            if too_much > 0.0 { (dip - shallowest, farthest - blow) } else { (deepest - dip, blow - nearest) };
        let paper = Work::Screw { name: "front_punching", by: 0.0 };
        let capstan = Work::Screw { name: "capstan_height", by: 0.0 };
        let paper_mm = 1e3 * paper.step();
        let papers =
            (too_much.abs() / paper_mm).ceil().min(((dip_room - ReadingQuantity::Dip.precision()) / paper_mm).floor());
        let work = if papers > 0.0 {
            let by = (papers.copysign(too_much) + 0.5 * chance.either_way()) * paper.step();
            paper.with_amount(by, 0.0)
        } else if too_much.abs() > ReadingQuantity::Aftertouch.precision() && blow_room > EIGHTH_MM {
            let by = (-too_much.signum() + 0.5 * chance.either_way()) * capstan.step();
            capstan.with_amount(by, 0.0)
        } else {
            return;
        };
        work.carry_out(piano, go_on).unwrap();
        *truth = Readings::of(piano, go_on).unwrap();
    }
}

/// A screw turned until its line reads what the sheet promises.
struct Turning<'a> {
    item: &'a Item,
    /// Reading before the first turn.
    begun: Option<f64>,
    /// All turns together.
    turned: f64,
    /// Whether it was turned back because the line could no longer be read: it stays where it can be again.
    is_back: bool,
}

impl<'a> Turning<'a> {
    fn new(item: &'a Item, begun: Option<f64>) -> Self {
        Turning { item, begun, turned: 0.0, is_back: false }
    }

    /// Reading that the sheet promises.
    fn promised(&self) -> Option<f64> {
        self.item.after.get(self.item.quantity)
    }

    /// Change of the reading per amount of work, as the sheet has it.
    fn expected_rate(&self) -> Option<f64> {
        let before = self.item.before.get(self.item.quantity)?;
        Some((self.promised()? - before) / self.item.work.amount())
    }

    /// Whole steps; of wires and springs, few.
    fn steps(&self, by: f64) -> Option<Work> {
        let step = self.item.work.step();
        let most = if [ReadingQuantity::Check, ReadingQuantity::Spring].contains(&self.item.quantity) {
            LITTLE
        } else {
            f64::INFINITY
        };
        let steps = (by / step).round().clamp(-most, most);
        (steps != 0.0).then(|| self.item.work.with_amount(steps * step, 0.0))
    }

    /// Whether a reading lies inside its range by more than its error.
    fn is_well_inside(&self, read: f64) -> bool {
        let [low, high] = self.item.quantity.line().range(KEY);
        let room = (read - low.unwrap_or(f64::NEG_INFINITY)).min(high.unwrap_or(f64::INFINITY) - read);
        room > self.item.quantity.precision()
    }

    /// The first turn: as far as the line reads from what is promised; none if it reads that already, or if it is well
    /// inside its range. Dip and blow are set for the aftertouch.
    fn first(&mut self) -> Option<Work> {
        let Work::Screw { .. } = self.item.work else { return Some(self.item.work.clone()) };
        let quantity = self.item.quantity;
        let Some(read) = self.begun else {
            // Read before, and lost by another line.
            let is_lost = self.item.before.get(quantity).is_some();
            return if is_lost { self.back() } else { Some(self.item.work.clone()) };
        };
        let (Some(promised), Some(rate)) = (self.promised(), self.expected_rate()) else {
            return Some(self.item.work.clone());
        };
        let off = promised - read;
        let is_set = ![ReadingQuantity::Dip, ReadingQuantity::Blow].contains(&quantity) && self.is_well_inside(read);
        if is_set || off.abs() <= quantity.precision() { None } else { self.steps(off / rate) }
    }

    /// A step to where the line can be read: back, or, of a check's wire that is bent toward the hammer, on.
    fn back(&mut self) -> Option<Work> {
        let before = self.item.before.get(self.item.quantity);
        let is_on_its_way =
            self.item.quantity == ReadingQuantity::Check && before.is_none_or(|before| self.promised() < Some(before));
        self.is_back |= !is_on_its_way;
        let on = self.item.work.step().copysign(self.item.work.amount());
        self.steps(if is_on_its_way { on } else { -on })
    }

    /// A further turn after one by `amount`, if the line does not read inside its range by a reading's error, and
    /// something else than promised by more than that.
    fn next(&mut self, amount: f64, read: Option<f64>) -> Option<Work> {
        let Work::Screw { .. } = self.item.work else { return None };
        self.turned += amount;
        let precision = self.item.quantity.precision();
        match (read, self.promised()) {
            (Some(read), Some(promised)) if !self.is_back => {
                if self.is_well_inside(read) {
                    return None;
                }
                let off = promised - read;
                let beyond = (off.abs() - precision).max(0.0).copysign(off);
                // As far as it was seen to go.
                let seen = self.begun.map(|begun| read - begun).filter(|moved| moved.abs() > 2.0 * precision);
                let rate = seen.map(|moved| moved / self.turned).or_else(|| self.expected_rate())?;
                self.steps(beyond / rate)
            }
            (Some(_), _) => None,
            (None, _) => self.back(),
        }
    }
}
