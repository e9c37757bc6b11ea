//! The readings and the lines of work as tables, for the terminal and for the page.

use erard::keyboard::note_name;
use erard_workshop::balance::{AFTERTOUCH_PER_CAPSTAN, BalancedKey, Bound, MOST_CAPSTAN_MM, Remedy, Withheld};
use erard_workshop::digits::signed;
use erard_workshop::worklist::{KeyLine, KeyboardList, Operation, Why, Work as Works};

use super::{LEAD_G, Work, capstan_text, front_weight_text, hammer_text, leads_text, remedy_text};
use crate::table::{Table, decimal};

/// What was weighed and what follows from it, a row for every key: `!` is out of the usual range, `?` by less than the
/// reading may be off, `^` sticks out from the neighbours.
pub(super) fn readings(work: &Work<'_>) -> Table<'static> {
    const HEADS: [&str; 11] =
        ["key", "note", "D g", "U g", "BW g", "F g", "usual F", "ratio", "SW g", "FW g", "inertia kg"];
    let row = |key: &BalancedKey| {
        let sticks_out = |quantity: &str| key.apart.iter().any(|apart| apart.quantity == quantity);
        let marked = |value: Option<f64>, decimals: usize, quantity: &str, out: &str| {
            let apart = if sticks_out(quantity) { " ^" } else { "" };
            format!("{}{out}{apart}", decimal(value, decimals))
        };
        let weighed = &key.measured;
        let friction = match (KeyboardList::is_friction_out(key), KeyboardList::is_friction_doubtful(key)) {
            (true, _) => " !",
            (_, true) => " ?",
            _ => "",
        };
        vec![
            format!("{}{}", weighed.key, if key.from_curves { " ~" } else { "" }),
            key.note.clone(),
            decimal(weighed.down_weight_g, 1),
            decimal(weighed.up_weight_g, 1),
            marked(key.balance_weight_g, 1, "balance_weight_g", ""),
            marked(key.friction_weight_g, 1, "friction_weight_g", friction),
            friction_range(weighed.key),
            marked(key.ratio, 2, "ratio", ""),
            marked(key.strike_weight_g, 1, "strike_weight_g", ""),
            decimal(weighed.front_weight_g, 1),
            decimal(key.inertia_kg, 3),
        ]
    };
    Table::of(HEADS, work.list.plan.keys.iter().map(row))
}

/// An operation that has lines: its heading, and its lines.
pub(super) struct Section<'w> {
    pub heading: &'static str,
    heads: &'static [&'static str],
    lines: Vec<&'w KeyLine>,
}

/// The operations that have lines, in the order of work.
pub(super) fn sections<'w>(work: &'w Work<'_>) -> Vec<Section<'w>> {
    let has_springs = has_springs(work);
    let sections = Operation::ALL.map(|operation| Section {
        heading: heading(operation),
        heads: heads(operation, has_springs),
        lines: work.list.lines.iter().filter(|line| line.operation == operation).collect(),
    });
    sections.into_iter().filter(|section| !section.lines.is_empty()).collect()
}

/// What to say where no key has a line; `None` where one has, or where leverage comes first.
pub(super) fn nothing_to_do(work: &Work<'_>) -> Option<&'static str> {
    let list = work.list;
    match (list.lines.is_empty() && list.leverage.is_none(), list.left.is_empty()) {
        (true, true) => Some("Nothing to do."),
        (true, false) => Some("Nothing to do by leads."),
        (false, _) => None,
    }
}

fn heading(operation: Operation) -> &'static str {
    match operation {
        Operation::Friction => {
            "Friction (key bushings, balance hole, centre pins, knuckle): ease it, then weigh these keys again"
        }
        Operation::Hammers => "Hammers, before any lead",
        Operation::Leads => "Key leads (in brackets: what the inertia at the front changes by)",
    }
}

/// Whether springs or magnets were weighed.
fn has_springs(work: &Work<'_>) -> bool {
    work.list.plan.keys.iter().any(|key| key.measured.assist_g.is_some())
}

fn heads(operation: Operation, has_springs: bool) -> &'static [&'static str] {
    match operation {
        Operation::Leads if has_springs => {
            &["key", "note", "leads", "or instead", "or hammer", "or capstan forward", "or spring", "then FW, D, U"]
        }
        Operation::Friction => &["key", "note", "what", "friction", "then D, U"],
        Operation::Hammers => &["key", "note", "what", "strike weight", "then D, U"],
        Operation::Leads => &["key", "note", "leads", "or instead", "or hammer", "or capstan forward", "then FW, D, U"],
    }
}

impl Section<'_> {
    /// Its lines as a table, with so many further columns of one text each; samples first, under their own heading
    /// where others follow.
    pub(super) fn table(&self, work: &Work<'_>, more: Option<(&'static str, &str)>) -> Table<'static> {
        let mut rows: Vec<Vec<String>> = Vec::new();
        let width = self.heads.len() + usize::from(more.is_some());
        let title = |rows: &mut Vec<Vec<String>>, text: &str| {
            let rest = std::iter::repeat_n(String::new(), width - 1);
            rows.push(std::iter::once(text.to_owned()).chain(rest).collect());
        };
        let has_rest = self.lines.iter().any(|line| !line.is_sample);
        for (at, line) in self.lines.iter().enumerate() {
            if has_rest && at == 0 {
                title(&mut rows, "samples at section ends: weigh them before you go on");
            }
            if at > 0 && self.lines[at - 1].is_sample && !line.is_sample {
                title(&mut rows, "the rest");
            }
            let row = cells(line, work).into_iter();
            rows.push(row.chain(more.map(|(_, text)| text.to_owned())).collect());
        }
        Table::of(self.heads.iter().copied().chain(more.map(|(head, _)| head)), rows)
    }
}

fn cells(line: &KeyLine, work: &Work<'_>) -> Vec<String> {
    let Some(key) = work.list.plan.keys.iter().find(|key| key.measured.key == line.key) else { return Vec::new() };
    let after = |weights: &[Option<f64>]| {
        weights.iter().map(|weight| weight.map_or("-".to_owned(), |g| format!("{g:.0}"))).collect::<Vec<_>>().join(", ")
    };
    let lengths = work.lengths;
    let mut cells = vec![line.key.to_string(), note_name(line.key)];
    let (down, up) = (line.after.down_g, line.after.up_g);
    match &line.work {
        Works::Friction { by_g } => {
            let now = decimal(key.friction_weight_g, 1);
            let what = format!("ease {:.0} g", -by_g);
            cells.extend([what, format!("{now} g, usual {}", friction_range(line.key)), after(&[down, up])]);
        }
        Works::Hammer { by_g } => {
            let [now, then] = [key.measured.strike_weight_g, line.after.strike_g].map(|g| decimal(g, 1));
            cells.extend([hammer_text(*by_g), format!("{now} to {then} g"), after(&[down, up])]);
        }
        works => {
            let what = |works: &Works| leads(works, key, work);
            let hammer = key.strike_change_g.filter(|g| g.abs() >= 0.05);
            cells.extend([
                what(works),
                line.instead.as_ref().map(what).or_else(|| unknown_leads(key, work)).unwrap_or("-".to_owned()),
                hammer.map_or("-".to_owned(), |by| format!("{by:+.1} g")),
                key.capstan_move_mm.map_or("-".to_owned(), |by| lengths.text(by, 1)),
            ]);
            if has_springs(work) {
                cells.push(key.assist_change_g.map_or("-".to_owned(), |by| format!("{} g", signed(by, 1))));
            }
            cells.push(after(&[line.after.front_g, down, up]));
        }
    }
    cells
}

/// The friction weights that are no fault, in words.
fn friction_range(key: usize) -> String {
    format!("to {:.1}", KeyboardList::usual_friction_g(key)[1])
}

/// Leads, and what they do to the inertia at the key's front.
fn leads(works: &Works, key: &BalancedKey, work: &Work<'_>) -> String {
    match works {
        Works::Leads(leads) => format!("{} ({} g)", leads_text(leads, work.lengths), signed(leads.inertia_g, 1)),
        works => front_weight_text(works.amount(), key.model.key_front_mm, work.lengths),
    }
}

/// Longest way of a lead, as a share of the key's front arm: the pin's and the front's ends need their wood.
const MOST_WAY: f64 = 0.6;

/// Where nobody said which leads are there: how far one would move for as much front weight.
fn unknown_leads(key: &BalancedKey, work: &Work<'_>) -> Option<String> {
    let by_g = key.front_change_g.filter(|by_g| *by_g > 0.0 && key.measured.leads.is_empty())?;
    let by_mm = by_g * key.model.key_front_mm / LEAD_G;
    // A lead farther than from the pin to the front is none.
    if by_mm > MOST_WAY * key.model.key_front_mm {
        return None;
    }
    let inertia_g = erard_workshop::balance::moved_inertia_g(LEAD_G, by_mm, key.model.key_front_mm);
    let way = work.lengths.text(by_mm, 0);
    Some(format!("{LEAD_G:.0} g {way} to the front ({} g)", signed(inertia_g, 1)))
}

/// What is worth saying below the readings.
pub(super) fn remarks(work: &Work<'_>) -> Vec<String> {
    let list = work.list;
    let (plan, target) = (&list.plan, list.plan.target);
    let from = aim_words(list);
    let inertia = target.inertia_kg.map_or(String::new(), |kg| format!(" and an inertia of {kg} kg"));
    let mut lines = vec![format!("Aim: a balance weight of {:.1} g ({from}){inertia}.", target.balance_weight_g)];
    lines.extend(leverage(work));
    lines.extend(capstans_cost(work));
    if has_springs(work) {
        lines.push("Springs or magnets are in the equation; down-weights without them are in weigh.csv. Like leads they take off D and U alike, without their inertia.".to_owned());
    }
    let out: Vec<&str> =
        plan.keys.iter().filter(|key| KeyboardList::is_friction_out(key)).map(|key| &*key.note).collect();
    if !out.is_empty() {
        lines.push(format!(
            "! Friction is out of its usual range: {}. It is in every weight, so it comes first.",
            out.join(", ")
        ));
    }
    let doubtful = plan.keys.iter().filter(|key| KeyboardList::is_friction_doubtful(key)).count();
    if doubtful > 0 {
        let keys = if doubtful == 1 { "key" } else { "keys" };
        lines.push(format!("? Friction of {doubtful} {keys} is out by less than a reading may be off: no work."));
    }
    if out.len() >= 4 && 2 * out.len() > plan.keys.iter().filter(|key| key.friction_weight_g.is_some()).count() {
        lines.push("More than half of the keys rub wrong: look for one cause (moist or worn bushings, dry knuckles, a damp room) before you ease key by key.".to_owned());
    }
    lines.extend(neighbours(work));
    if plan.keys.iter().any(|key| key.from_curves) {
        lines.push("~ Something was not weighed: the smooth curve over the keyboard takes its place.".to_owned());
    }
    let missing = erard::keyboard::KEYS - plan.keys.len();
    if missing > 0 {
        lines.push(format!("{missing} keys were not weighed; their aims are in weigh.json (curves)."));
    }
    lines
}

/// What is said of a leverage that is out at most keys.
fn leverage(work: &Work<'_>) -> Option<String> {
    let out = work.list.leverage.as_ref()?;
    let ([low, high], by_mm) = (out.ratios, out.capstan_move_mm);
    let way = if by_mm > 0.0 { "to the player" } else { "to the back" };
    let way = format!("{} {way}", work.lengths.text(by_mm.abs(), 1));
    let cost = work.lengths.text(AFTERTOUCH_PER_CAPSTAN * by_mm.abs(), 1);
    let cost = if by_mm > 0.0 {
        format!("costs about {cost} of aftertouch")
    } else {
        format!("gives about {cost} of aftertouch")
    };
    let rest = if (out.reaches - out.aim).abs() > 0.05 {
        " The rest is the knuckles' distance, or the hammers' weight."
    } else {
        ""
    };
    Some(format!(
        "Leverage before hammers and leads: the ratio of {} of {} keys is out on the same side ({low:.2} to {high:.2}), so the cause is one. \
         The capstan line {way} brings the naturals to about {:.2} (aim {:.2}) and {cost}; try it on sample keys, and set blow and dip anew.{rest}",
        out.keys.len(),
        out.of,
        out.reaches,
        out.aim
    ))
}

/// What a move of single capstans costs elsewhere.
fn capstans_cost(work: &Work<'_>) -> Option<String> {
    let has_leads = |key: &BalancedKey| {
        work.list.lines.iter().any(|line| line.key == key.measured.key && line.operation == Operation::Leads)
    };
    let moved = work.list.plan.keys.iter().filter(|key| has_leads(key)).filter_map(|key| key.capstan_move_mm);
    let most = moved.filter(|by_mm| by_mm.abs() >= 0.05).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    let cost = work.lengths.text(AFTERTOUCH_PER_CAPSTAN * most.abs(), 1);
    let way = capstan_text(most, work.lengths);
    let gain = if most > 0.0 { "costs" } else { "gives" };
    Some(format!("A capstan {way} {gain} about {cost} of aftertouch, and blow and dip are set anew."))
}

/// Remedies that are not given, and why.
fn withheld(work: &Work<'_>) -> Vec<String> {
    let keys = || work.list.plan.keys.iter().filter(move |key| !waits(work, key));
    let each = |of: &dyn Fn(&Withheld) -> Option<String>| {
        let told = keys().flat_map(|key| key.withheld.iter().filter_map(move |one| Some((&*key.note, of(one)?))));
        told.map(|(note, text)| format!("{note} {text}")).collect::<Vec<_>>().join(", ")
    };
    let lengths = work.lengths;
    let heel = each(&|one| match (&one.remedy, one.bound) {
        (Remedy::Capstan(by_mm), Bound::Heel) => Some(capstan_text(*by_mm, lengths)),
        _ => None,
    });
    let shank = each(&|one| match (&one.remedy, one.bound) {
        (Remedy::Strike(by_g), Bound::StrikeWeight(then_g)) => Some(format!("{by_g:+.1} g (to {then_g:.1} g)")),
        _ => None,
    });
    let model = each(&|one| match one.bound {
        Bound::Model(Some(g)) => Some(format!("{}: {g:+.1} g in the model", remedy_text(&one.remedy, lengths))),
        Bound::Model(None) => Some(format!("{}: no weight moves the key then", remedy_text(&one.remedy, lengths))),
        _ => None,
    });
    let aftertouch = each(&|one| match (&one.remedy, one.bound) {
        (Remedy::Capstan(by_mm), Bound::Aftertouch(then_mm)) => {
            Some(format!("{} (to {})", capstan_text(*by_mm, lengths), lengths.text(then_mm, 1)))
        }
        _ => None,
    });
    let as_checked = each(&|one| match (&one.remedy, one.bound) {
        (Remedy::Capstan(by_mm), Bound::AsChecked) => Some(capstan_text(*by_mm, lengths)),
        _ => None,
    });
    let springs = each(&|one| match (&one.remedy, one.bound) {
        (Remedy::Assist(by_g), Bound::Assist(then_g)) => Some(format!("{} g (to {then_g:.1} g)", signed(*by_g, 1))),
        _ => None,
    });
    let most = lengths.text(MOST_CAPSTAN_MM, 0);
    [
        (heel, format!("Capstans not moved, for more than {most} leaves the heel and takes the aftertouch")),
        (aftertouch, "Capstans not moved, for no usual dip makes up for the aftertouch".to_owned()),
        (springs, "Springs left, for they would take off less than nothing or more than touch bears".to_owned()),
        (shank, "Hammers left, for a strike weight far out of its usual range".to_owned()),
        (model, "Withheld, for the dynamic model does not do what the equation says".to_owned()),
        (as_checked, "Capstans not moved, for a move no larger was refuted at a checked key".to_owned()),
    ]
    .into_iter()
    .filter(|(keys, _)| !keys.is_empty())
    .map(|(keys, why)| format!("{why}: {keys}."))
    .collect()
}

/// Whether a key's hammer and leads wait for the leverage.
fn waits(work: &Work<'_>, key: &BalancedKey) -> bool {
    work.list.leverage.as_ref().is_some_and(|out| out.keys.contains(&key.measured.key))
}

fn aim_words(list: &KeyboardList) -> &'static str {
    use erard_workshop::worklist::AimFrom::{Asked, Median, NearMedian, Trade};
    match list.aim_from {
        Asked => "asked for",
        Median => "the median of these keys",
        NearMedian => "the nearest to the median of these keys with which D and U can all be usual",
        Trade => "the trade's; too few keys for a median",
    }
}

/// Keys that stick out from their neighbours, quantity by quantity.
fn neighbours(work: &Work<'_>) -> Vec<String> {
    const QUANTITIES: [(&str, &str, usize, &str); 4] = [
        ("friction_weight_g", "Friction", 1, ", g"),
        ("strike_weight_g", "Strike weight", 1, ", g"),
        ("ratio", "Ratio", 2, ""),
        ("balance_weight_g", "Balance weight", 1, ", g"),
    ];
    let of = |(quantity, name, decimals, unit): (&str, &str, usize, &str)| {
        let keys: Vec<String> = work
            .list
            .plan
            .keys
            .iter()
            .filter_map(|key| {
                let apart = key.apart.iter().find(|apart| apart.quantity == quantity)?;
                let (own, beside) = (apart.value, apart.neighbours);
                Some(format!("{} {own:.decimals$} (neighbours {beside:.decimals$})", key.note))
            })
            .collect();
        (!keys.is_empty()).then(|| format!("^ {name} that sticks out{unit}: {}.", keys.join(", ")))
    };
    QUANTITIES.into_iter().filter_map(of).collect()
}

/// What stays, and why.
pub(super) fn stays(work: &Work<'_>) -> Vec<String> {
    let of = |why: &Why| {
        let keys = work.list.left.iter().filter(|(_, own)| own == why).map(|(key, _)| note_name(*key));
        keys.collect::<Vec<_>>().join(", ")
    };
    let (friction, ceiling, leverage) = (of(&Why::Friction), of(&Why::Ceiling), of(&Why::Leverage));
    let mut lines = Vec::new();
    if !leverage.is_empty() {
        lines.push(format!("Hammers and leads of {leverage} wait: first leverage, then weigh again."));
    }
    if !friction.is_empty() {
        lines.push(format!("Hammers and leads of {friction} wait: first friction, then weigh again."));
    }
    if !ceiling.is_empty() {
        lines.push(format!(
            "{ceiling}: as much lead as a key should have, and still too heavy: use lighter hammers or less leverage."
        ));
    }
    lines.extend(withheld(work));
    lines
}
