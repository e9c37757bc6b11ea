//! Sensors' laws: the share of a key's travel at a reading between those of its two stops.

use moreau::Scalar;

/// A sensor's law, with its own points on the heap.
#[cfg(feature = "std")]
pub type Law = LawOf<Vec<[f64; 2]>>;
/// A sensor's law, with its own points in flash.
pub type FixedLaw = LawOf<&'static [[f64; 2]]>;

/// A sensor's law. All are exact at both stops.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "std", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "std", serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields))]
pub enum LawOf<P> {
    /// Travel in proportion to the reading.
    Linear {},
    /// A reflective optical sensor CNY-70 under the back of a key, on the smooth curve through marks of a ruler
    /// ([`CNY70`]). The curve depends on the mounting, so a table of your own is better.
    Cny70 {},
    /// A Hall sensor on the axis of a small magnet, whose field falls with the third power of the distance.
    Hall {
        /// Distance where they are nearest, mm.
        nearest_mm: f64,
        /// Whether the key's rest is there.
        at_rest: bool,
    },
    /// A table of your own points: share of the reading's range, and share of the travel, both from 0 to 1, ascending.
    Table {
        /// The points.
        points: P,
    },
}

/// Share of a CNY-70's range at even shares of the travel, 0 to 15 fifteenths, read by Greg Zweigle at marks of a ruler
/// on a Kawai KG-3C, its key E4 (Piano-Data, `https://github.com/gzweigle/Piano-Data`, commit c7224eb, MIT licence:
/// `damper_cal_points`). His marks are irregular by up to 0.25 mm, which makes local speeds wrong by a quarter; these
/// lie on the smooth curve through them (`recordings/calibrate.py`, `law`).
pub const CNY70: [f64; 16] = [
    0.0, 0.0011, 0.0024, 0.0051, 0.0084, 0.0134, 0.0214, 0.0339, 0.0536, 0.0843, 0.1317, 0.2036, 0.3105, 0.4665,
    0.6890, 1.0,
];

/// Fault of a sensor's law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum LawFault {
    /// The points do not rise from [0, 0] to [1, 1].
    Points {
        /// Index of the point, from 0.
        index: usize,
        /// The point found.
        found: [f64; 2],
    },
    /// Too few points.
    TooFew(usize),
    /// The distance is not positive and finite.
    Nearest(f64),
    /// The travel does not rise to this point, or a number is not finite.
    Travel {
        /// Index of the point, from 0.
        index: usize,
    },
    /// The readings do not change with the travel.
    Flat,
}

impl core::fmt::Display for LawFault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            LawFault::Points { index, found } => {
                write!(f, "point {}: found {found:?}; expected shares that rise from [0, 0] to [1, 1]", index + 1)
            }
            LawFault::TooFew(count) => write!(f, "{count} points; expected at least two"),
            LawFault::Travel { index } => {
                write!(f, "point {}: expected travel that rises from the rest to the bottom", index + 1)
            }
            LawFault::Flat => f.write_str("the readings do not change with the travel"),
            LawFault::Nearest(mm) => write!(f, "nearest_mm is {mm}; expected a number from 0.1 to 100"),
        }
    }
}

impl core::error::Error for LawFault {}

#[cfg(feature = "std")]
impl Law {
    /// Makes a law from your own points, readings and travel in any units, from the rest to the bottom. Readings that
    /// do not rise from one to the next, or fall where they fall on the whole (a sensor that sees nothing of the
    /// beginning, noise), are averaged until they do: the nearest monotone curve (least squares, pool adjacent
    /// violators; M. Ayer et al., Ann. Math. Statist. 26 (1955) 641). The stops keep their travel. Also returns how
    /// many points were averaged, and the largest change of a reading.
    ///
    /// # Errors
    /// [`LawFault::TooFew`], [`LawFault::Travel`] where the travel does not rise, [`LawFault::Flat`] where all readings
    /// are averaged to one.
    pub fn of_points(points: &[[f64; 2]]) -> Result<(Self, usize, f64), LawFault> {
        if points.len() < 2 {
            return Err(LawFault::TooFew(points.len()));
        }
        let is_bad = |i: &usize| {
            !points[*i].iter().all(|number| number.is_finite()) || (*i > 0 && points[*i][1] <= points[*i - 1][1])
        };
        if let Some(index) = (0..points.len()).find(is_bad) {
            return Err(LawFault::Travel { index });
        }
        let count = points.len() as f64;
        let middle = |of: usize| points.iter().map(|point| point[of]).sum::<f64>() / count;
        let [r, x] = [middle(0), middle(1)];
        let slope: f64 = points.iter().map(|point| (point[0] - r) * (point[1] - x)).sum();
        // Points that are averaged: the sum of their readings, rising, and where they begin and end.
        let mut pools: Vec<(f64, usize, usize)> = Vec::new();
        let mean = |&(sum, from, to): &(f64, usize, usize)| sum / (to - from) as f64;
        for (i, [reading, _]) in points.iter().enumerate() {
            let mut pool = (reading * slope.signum(), i, i + 1);
            while let Some(before) = pools.last().filter(|before| mean(before) >= mean(&pool)) {
                pool = (before.0 + pool.0, before.1, pool.2);
                pools.pop();
            }
            pools.push(pool);
        }
        let [Some(first), Some(last)] = [pools.first(), pools.last()] else { return Err(LawFault::TooFew(0)) };
        if pools.len() < 2 {
            return Err(LawFault::Flat);
        }
        let (r0, range) = (mean(first), mean(last) - mean(first));
        let (x0, travel) = (points[0][1], points[points.len() - 1][1] - points[0][1]);
        let share = |(index, pool): (usize, &(f64, usize, usize))| {
            let (_, from, to) = *pool;
            let way = match index {
                0 => points[0][1],
                _ if index == pools.len() - 1 => points[points.len() - 1][1],
                _ => points[from..to].iter().map(|point| point[1]).sum::<f64>() / (to - from) as f64,
            };
            [(mean(pool) - r0) / range, (way - x0) / travel]
        };
        let mut shares: Vec<[f64; 2]> = pools.iter().enumerate().map(share).collect();
        // Exact at both stops, whatever the rounding.
        if let [first, .., last] = &mut shares[..] {
            (*first, *last) = ([0.0; 2], [1.0; 2]);
        }
        let own = pools.iter().filter(|(_, from, to)| to - from > 1);
        let averaged = own.clone().map(|(_, from, to)| to - from).sum();
        let change = |pool: &(f64, usize, usize)| {
            let of = |point: &[f64; 2]| (point[0] * slope.signum() - mean(pool)).abs();
            points[pool.1..pool.2].iter().map(of).fold(0.0, f64::max)
        };
        let changed = own.map(change).fold(0.0, f64::max);
        let law = Law::Table { points: shares };
        law.check()?;
        Ok((law, averaged, changed))
    }
}

impl<P: AsRef<[[f64; 2]]>> LawOf<P> {
    /// Checks its numbers.
    ///
    /// # Errors
    /// [`LawFault`].
    pub fn check(&self) -> Result<(), LawFault> {
        match self {
            LawOf::Linear {} | LawOf::Cny70 {} => Ok(()),
            LawOf::Hall { nearest_mm, .. } if (0.1..=100.0).contains(nearest_mm) => Ok(()),
            LawOf::Hall { nearest_mm, .. } => Err(LawFault::Nearest(*nearest_mm)),
            LawOf::Table { points } if points.as_ref().len() < 2 => Err(LawFault::TooFew(points.as_ref().len())),
            LawOf::Table { points } => {
                let points = points.as_ref();
                let last = points.len() - 1;
                let is_sound = |i: usize| match i {
                    0 => points[0] == [0.0, 0.0],
                    i => {
                        points[i - 1][0] < points[i][0]
                            && points[i - 1][1] < points[i][1]
                            && (i < last || points[i] == [1.0, 1.0])
                    }
                };
                match (0..=last).find(|i| !is_sound(*i)) {
                    Some(index) => Err(LawFault::Points { index, found: points[index] }),
                    None => Ok(()),
                }
            }
        }
    }

    /// The share of its travel, m, that a key has gone, from the share of the reading's range; beyond the stops the law
    /// continues linearly.
    #[must_use]
    pub fn share<T: Scalar>(&self, read: T, travel_m: T) -> T {
        match self {
            LawOf::Linear {} => read,
            LawOf::Cny70 {} => {
                let marks = |i: usize| [CNY70[i], i as f64 / 15.0];
                along(CNY70.len(), &marks, read)
            }
            LawOf::Table { points } => along(points.as_ref().len(), &|i| points.as_ref()[i], read),
            LawOf::Hall { nearest_mm, at_rest } => {
                // Distances in travels.
                let near = T::from_f64(1e-3 * nearest_mm) / travel_m;
                let (one, two) = (T::ONE, T::from_f64(2.0));
                let cube = |d: T| one / (d * d * d);
                let root = |x: T| T::from_f64(libm::cbrt(x.to_f64()));
                let toward = |nearness: T| {
                    let field = cube(near + one) + nearness * (cube(near) - cube(near + one));
                    one + near - root(one / field.max(cube(near + two)))
                };
                if *at_rest { one - toward(one - read) } else { toward(read) }
            }
        }
    }
}

/// Linear interpolation between points; the first and the last segment continue beyond the ends.
fn along<T: Scalar>(count: usize, point: &dyn Fn(usize) -> [f64; 2], x: T) -> T {
    let end = (1..count - 1).find(|&i| x <= T::from_f64(point(i)[0])).unwrap_or(count - 1);
    let ([x0, y0], [x1, y1]) = (point(end - 1).map(T::from_f64), point(end).map(T::from_f64));
    y0 + (x - x0) * (y1 - y0) / (x1 - x0)
}
