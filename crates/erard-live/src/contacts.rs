//! Contacts under a key: from the instants at which they close and open to notes. Without a heap.

use erard_midi::Event;

use crate::limits::MAX_HAMMER_M_PER_S;

/// Most contacts of a key.
pub const MAX_CONTACTS: usize = 3;
/// Most points of a table.
pub const MAX_POINTS: usize = 24;
/// Counts of velocity for a change of the hammer speed by a factor of e: 25 for each factor of two.
pub(crate) const COUNTS_PER_E: f64 = 25.0 / core::f64::consts::LN_2;

/// A hammer speed at a time between two contacts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Time from the upper contact to the lowest, s.
    pub between_s: f64,
    /// Hammer speed at the string, m/s.
    pub hammer_speed_m_per_s: f64,
    /// From the lowest contact to the impact, s; negative if the hammer is there first.
    pub delay_s: f64,
    /// Half of the difference between touches, counts of velocity.
    pub touch_counts: f64,
}

/// Fault of a table or of contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ContactFault {
    /// There are fewer than two points or more than [`MAX_POINTS`].
    Points(usize),
    /// A point, from 0: the time does not rise, the speed does not fall, or a number is out of range.
    Point(usize),
    /// There are fewer than two contacts or more than [`MAX_CONTACTS`].
    Count(usize),
    /// The depths do not rise, or one is out of range, mm.
    Depth(f64),
    /// The period of the scan, a phase within it or the time of bounces is out of range, s.
    Time(f64),
    /// The contact that ends notes is not above the lowest one.
    Off(usize),
}

impl core::fmt::Display for ContactFault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            ContactFault::Points(found) => write!(f, "{found} points; expected 2 to {MAX_POINTS}"),
            ContactFault::Point(index) => write!(
                f,
                "point {}: expected times that rise above 0 ms, and hammer speeds that fall, at most {MAX_HAMMER_M_PER_S} \
                 m/s",
                index + 1
            ),
            ContactFault::Count(found) => write!(f, "{found} contacts; expected 2 or {MAX_CONTACTS}"),
            ContactFault::Depth(mm) => write!(f, "found {mm} mm; expected depths from 0.1 to 20 mm that rise"),
            ContactFault::Time(s) => write!(f, "found {s} s; expected 0 to 0.1 s, a phase within the period"),
            ContactFault::Off(found) => {
                write!(f, "found contact {}; expected a contact above the lowest one", found.wrapping_add(1))
            }
        }
    }
}

impl core::error::Error for ContactFault {}

/// Hammer speeds by the time between two contacts. Straight lines between points, in the logarithms of time and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedTable {
    count: usize,
    points: [Point; MAX_POINTS],
}

impl SpeedTable {
    /// Makes a table of points whose times rise and whose speeds fall.
    ///
    /// # Errors
    /// [`ContactFault::Points`], [`ContactFault::Point`].
    pub fn new(points: &[Point]) -> Result<Self, ContactFault> {
        if !(2..=MAX_POINTS).contains(&points.len()) {
            return Err(ContactFault::Points(points.len()));
        }
        let mut table = SpeedTable { count: points.len(), points: [Point::default(); MAX_POINTS] };
        for (i, point) in points.iter().enumerate() {
            let Point { between_s, hammer_speed_m_per_s: speed, delay_s, touch_counts } = *point;
            let is_next = i == 0 || (between_s > points[i - 1].between_s && speed < points[i - 1].hammer_speed_m_per_s);
            let is_in_range = between_s > 0.0
                && between_s <= 10.0
                && speed > 0.0
                && speed <= MAX_HAMMER_M_PER_S
                && delay_s.abs() <= 1.0
                && (0.0..=127.0).contains(&touch_counts);
            if !(is_next && is_in_range) {
                return Err(ContactFault::Point(i));
            }
            table.points[i] = *point;
        }
        Ok(table)
    }

    /// Its points, the fastest first.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points[..self.count]
    }

    /// The point at a time, s: the first one's values before it; `None` after the last one, for a press that throws no
    /// hammer to its string.
    #[must_use]
    pub fn at(&self, between_s: f64) -> Option<Point> {
        let points = self.points();
        let (first, last) = (points[0], points[points.len() - 1]);
        if between_s.is_nan() || between_s > last.between_s {
            return None;
        }
        if between_s <= first.between_s {
            return Some(first);
        }
        let [from, to] = self.segment(between_s);
        let share = libm::log(between_s / from.between_s) / libm::log(to.between_s / from.between_s);
        let along = |from: f64, to: f64| from + share * (to - from);
        let ratio = libm::log(to.hammer_speed_m_per_s / from.hammer_speed_m_per_s);
        Some(Point {
            between_s,
            hammer_speed_m_per_s: from.hammer_speed_m_per_s * libm::exp(share * ratio),
            delay_s: along(from.delay_s, to.delay_s),
            touch_counts: along(from.touch_counts, to.touch_counts),
        })
    }

    /// Standard deviation of the velocity, counts, at a time between contacts, s, that are scanned with a period, s:
    /// each edge is seen up to a period late, so that the difference of two has a standard deviation of the period over
    /// the root of six.
    #[must_use]
    pub fn time_counts(&self, between_s: f64, period_s: f64) -> f64 {
        let [from, to] = self.segment(between_s);
        let slope =
            libm::log(to.hammer_speed_m_per_s / from.hammer_speed_m_per_s) / libm::log(to.between_s / from.between_s);
        let error = period_s / libm::sqrt(6.0) / between_s.max(period_s).max(self.points[0].between_s);
        COUNTS_PER_E * slope.abs() * error
    }

    fn segment(&self, between_s: f64) -> [Point; 2] {
        let points = self.points();
        let last = points.len() - 1;
        let end = (1..last).find(|&i| between_s <= points[i].between_s).unwrap_or(last);
        [points[end - 1], points[end]]
    }
}

/// The contacts of a keyboard, and what follows from their edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// Depths of the key's front at which its contacts close, m, the upper one first.
    pub depths_m: [f64; MAX_CONTACTS],
    /// Number of contacts, 2 or 3.
    pub count: usize,
    /// Hammer speeds by the time from each contact to the lowest one.
    pub tables: [SpeedTable; MAX_CONTACTS - 1],
    /// Period of the scan, s; 0 for edges that interrupts report.
    pub period_s: f64,
    /// How long after its time stamp each contact is read, s, within the period.
    pub phases_s: [f64; MAX_CONTACTS],
    /// Changes of a contact within this time after an edge are bounces of it, s.
    pub bounce_s: f64,
    /// The contact, from 0, whose opening ends a note: the nearest to where the key sets its damper down.
    pub off: usize,
}

impl ContactLaw {
    /// Checks its numbers.
    ///
    /// # Errors
    /// [`ContactFault`].
    pub fn check(&self) -> Result<(), ContactFault> {
        if !(2..=MAX_CONTACTS).contains(&self.count) {
            return Err(ContactFault::Count(self.count));
        }
        let (depths_m, phases_s) = (&self.depths_m[..self.count], &self.phases_s[..self.count]);
        ContactLaw::check_contacts(depths_m, phases_s, self.period_s, self.bounce_s)?;
        if self.off >= self.count - 1 { Err(ContactFault::Off(self.off)) } else { Ok(()) }
    }

    /// Checks the depths of contacts, m, the phases of their scan, s, its period, s, and the time of bounces, s.
    ///
    /// # Errors
    /// [`ContactFault`].
    pub fn check_contacts(
        depths_m: &[f64],
        phases_s: &[f64],
        period_s: f64,
        bounce_s: f64,
    ) -> Result<(), ContactFault> {
        if !(2..=MAX_CONTACTS).contains(&depths_m.len()) {
            return Err(ContactFault::Count(depths_m.len()));
        }
        let is_bad =
            |i: &usize| !(0.1e-3..=20e-3).contains(&depths_m[*i]) || (*i > 0 && depths_m[*i] <= depths_m[*i - 1]);
        if let Some(i) = (0..depths_m.len()).find(is_bad) {
            return Err(ContactFault::Depth(1e3 * depths_m[i]));
        }
        let phases = phases_s.iter().map(|phase_s| (*phase_s, period_s));
        for (s, most_s) in [(period_s, 0.1), (bounce_s, 0.1)].into_iter().chain(phases) {
            if !(0.0..=most_s).contains(&s) {
                return Err(ContactFault::Time(s));
            }
        }
        Ok(())
    }

    /// Tables by the upper contact's number, from 0.
    #[must_use]
    pub fn tables(&self) -> &[SpeedTable] {
        &self.tables[..self.count - 1]
    }
}

/// Counts of one key's contacts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ContactCounts {
    /// Changes that were bounces.
    pub bounces: u64,
    /// Times that the lowest contact closed although no contact above it had closed since the last note.
    pub untimed: u64,
    /// Times that the key came to its lowest contact too slowly to throw a hammer.
    pub slow: u64,
    /// Times that a contact closed after the one below it.
    pub swapped: u64,
    /// Times that the contacts closed in less than half the time of the table's fastest press: no key does that, but
    /// wires that touch do. The note has the table's highest speed.
    pub fast: u64,
}

/// One contact.
#[derive(Debug, Clone, Copy)]
struct Contact {
    is_made: bool,
    /// Instant of its last edge, s.
    since_s: f64,
    /// What was reported last, bounces included, and when, s.
    reported: (bool, f64),
    /// Whether it has closed since the last note.
    is_fresh: bool,
}

/// The contacts of one key.
#[derive(Debug, Clone)]
pub struct ContactKey {
    contacts: [Contact; MAX_CONTACTS],
    sounds: bool,
    /// What was counted.
    pub counts: ContactCounts,
}

impl Default for ContactKey {
    fn default() -> Self {
        ContactKey::new()
    }
}

impl ContactKey {
    /// A key at rest.
    #[must_use]
    pub fn new() -> Self {
        let open = Contact { is_made: false, since_s: f64::NEG_INFINITY, reported: (false, 0.0), is_fresh: false };
        ContactKey { contacts: [open; MAX_CONTACTS], sounds: false, counts: ContactCounts::default() }
    }

    /// Whether no contact is closed and no note sounds.
    #[must_use]
    pub fn is_up(&self) -> bool {
        !self.sounds && !self.contacts.iter().any(|one| one.is_made)
    }

    /// Takes an edge: the contact, from 0, its instant, s, and whether it has closed. Instants do not descend. Sends
    /// the resulting events; a contact that the law does not have is ignored.
    pub fn take(
        &mut self,
        law: &ContactLaw,
        (contact, time_s, is_made): (usize, f64, bool),
        send: &mut dyn FnMut(Event),
    ) {
        self.until(law, time_s, send);
        let Some(own) = self.contacts[..law.count].get_mut(contact) else { return };
        if own.reported.0 == is_made {
            return;
        }
        own.reported = (is_made, time_s);
        if time_s - own.since_s < law.bounce_s {
            self.counts.bounces += 1;
        } else {
            self.edge(law, contact, send);
        }
    }

    /// Goes on to an instant, s: a contact that stayed changed after its bounces has changed.
    pub fn until(&mut self, law: &ContactLaw, time_s: f64, send: &mut dyn FnMut(Event)) {
        let changed = |(i, one): (usize, &Contact)| {
            let is_over = one.reported.0 != one.is_made && time_s - one.since_s >= law.bounce_s;
            is_over.then_some((one.reported.1, i))
        };
        while let Some((_, first)) =
            self.contacts.iter().enumerate().filter_map(changed).min_by(|a, b| a.0.total_cmp(&b.0))
        {
            self.edge(law, first, send);
        }
    }

    /// Opens all contacts at an instant, s; nobody saw the key come up.
    pub fn let_go(&mut self, time_s: f64, send: &mut dyn FnMut(Event)) {
        let counts = self.counts;
        if core::mem::take(&mut self.sounds) {
            send(Event::Off { time_s, release_m_per_s: None });
        }
        *self = ContactKey { counts, ..ContactKey::new() };
    }

    /// A contact changes to what was reported last.
    fn edge(&mut self, law: &ContactLaw, contact: usize, send: &mut dyn FnMut(Event)) {
        let lowest = law.count - 1;
        let own = &mut self.contacts[contact];
        (own.is_made, own.since_s) = own.reported;
        own.is_fresh |= own.is_made;
        let is_made = own.is_made;
        if is_made && contact == lowest {
            self.strike(law, send);
        } else if is_made && self.contacts[contact + 1].is_made {
            self.counts.swapped += 1;
        } else if !is_made && !self.contacts[law.off].is_made && core::mem::take(&mut self.sounds) {
            let below = self.contacts[law.off + 1];
            let way_m = law.depths_m[law.off + 1] - law.depths_m[law.off];
            let way_s = (self.read_s(law, law.off) - self.read_s(law, law.off + 1)).max(law.period_s);
            let is_seen = contact == law.off && !below.is_made && way_s > 0.0;
            let time_s = self.read_s(law, contact) - 0.5 * law.period_s;
            send(Event::Off { time_s, release_m_per_s: is_seen.then(|| way_m / way_s) });
        }
    }

    /// Instant at which a contact's last edge was read, s.
    fn read_s(&self, law: &ContactLaw, contact: usize) -> f64 {
        self.contacts[contact].since_s + law.phases_s[contact]
    }

    /// The lowest contact has closed.
    fn strike(&mut self, law: &ContactLaw, send: &mut dyn FnMut(Event)) {
        let lowest = law.count - 1;
        let at_s = self.read_s(law, lowest);
        // Of the contacts above, the one whose time errs least.
        let (mut best, mut is_fast): (Option<(f64, Option<Point>)>, _) = (None, false);
        for (upper, table) in law.tables().iter().enumerate() {
            let between_s = at_s - self.read_s(law, upper);
            let contact = &self.contacts[upper];
            if !(contact.is_made && contact.is_fresh) || between_s < -law.period_s {
                continue;
            }
            let found = table.at(between_s);
            let time_counts = table.time_counts(between_s, law.period_s);
            let error = found.map_or(f64::MAX, |point| libm::hypot(point.touch_counts, time_counts));
            if best.is_none_or(|(least, _)| error < least) {
                best = Some((error, found));
                is_fast = between_s < 0.5 * table.points()[0].between_s;
            }
        }
        self.contacts.iter_mut().for_each(|one| one.is_fresh = false);
        match best {
            None => self.counts.untimed += 1,
            Some((_, None)) => self.counts.slow += 1,
            Some((_, Some(Point { hammer_speed_m_per_s, delay_s, .. }))) => {
                self.sounds = true;
                self.counts.fast += u64::from(is_fast);
                send(Event::On { time_s: at_s - 0.5 * law.period_s + delay_s, hammer_speed_m_per_s });
            }
        }
    }
}
