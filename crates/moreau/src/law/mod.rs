//! Contact laws: one file for each, and one line for each below. A law says its numbers in a constant table
//! ([`LawNumber`]) and what it does through one hook (`hook.rs`), which is dispatched statically. `../law_contract.rs`
//! holds every law in the list to the hook's contract with generated data.
//!
//! What looks like a law and is none:
//! - **The sign of a set-valued felt** is an unknown of the one-step problem (`dry_felts.rs`), as Coulomb's force is:
//!   no function of the path gives it.
//! - **Friction that grows while it sticks** (`dwell.rs`) changes the bound of a friction law, along the surface or in
//!   a pivot. A contact law acts along the normal.
//! - **A surface that yields** (`surface.rs`) is what a felt presses on. Any law presses on it: the step solves F =
//!   P(rate - A F) for the force, P being the law's.

mod elastoplastic;
mod hereditary;
mod hook;
mod hunt_crossley;
mod iwan;
mod number;
mod quadratic;
mod rate_part;
mod set_valued;
mod slider;
mod spring;

pub use elastoplastic::Elastoplastic;
pub use hereditary::Hereditary;
pub use hook::MEMORY;
pub use hunt_crossley::HuntCrossley;
pub use iwan::Iwan;
pub use number::{LAW_NUMBERS, LawNumber, Range};
pub use quadratic::Quadratic;
pub use set_valued::SetValued;
pub use spring::Exponent;

use crate::real::{Mask, Real, Scalar, join};
use crate::timing::Timing;
use hook::Law;
pub(crate) use hook::{Memory, Pressing};
pub(crate) use rate_part::{CurvatureBound, Form, RatePart};
pub(crate) use spring::{Curvature, FAR, ONSET, Pressed, Spring, TINY};

/// Makes [`Loss`], the list of tables, and the calls of the hook.
macro_rules! laws {
    ($($(#[$doc:meta])* $law:ident)*) => {
        /// Law of a felt's energy loss.
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[non_exhaustive]
        pub enum Loss<T> {
            $($(#[$doc])* $law($law<T>),)*
        }

        $(impl<T> From<$law<T>> for Loss<T> {
            fn from(law: $law<T>) -> Self {
                Loss::$law(law)
            }
        })*

        /// The laws' tables of numbers, in the order of [`Loss::law`].
        pub const LAWS: &[&[LawNumber]] = &[$(<$law<f64> as Law<f64>>::NUMBERS,)*];

        enum Place {
            $($law,)*
        }

        impl<T: Real> Loss<T> {
            /// Its place in [`LAWS`].
            pub fn law(&self) -> usize {
                match self {
                    $(Loss::$law(_) => Place::$law as usize,)*
                }
            }

            /// The law at a place of [`LAWS`], with numbers in the order of its table; zeros beyond them. `None` for a
            /// place beyond them.
            pub fn with(law: usize, numbers: [T; LAW_NUMBERS]) -> Option<Self> {
                $(if law == Place::$law as usize {
                    return Some(Loss::$law($law::with(numbers)));
                })*
                None
            }

            /// Its numbers, in the order of its table; zeros beyond them.
            pub fn numbers(&self) -> [T; LAW_NUMBERS] {
                match self {
                    $(Loss::$law(law) => law.numbers(),)*
                }
            }

            /// Numbers of its internal state.
            pub(crate) fn remembers(&self) -> usize {
                match self {
                    $(Loss::$law(_) => <$law<T> as Law<T>>::REMEMBERS,)*
                }
            }

            pub(crate) fn rate_part(&self) -> Form<T> {
                match self {
                    $(Loss::$law(law) => law.rate_part(),)*
                }
            }

            pub(crate) fn set_valued(&self) -> Option<T> {
                match self {
                    $(Loss::$law(law) => law.set_valued(),)*
                }
            }

            pub(crate) fn largest(&self) -> T {
                match self {
                    $(Loss::$law(law) => law.largest(),)*
                }
            }

            pub(crate) fn effective_exponent(&self, exponent: T) -> T {
                match self {
                    $(Loss::$law(law) => law.effective_exponent(exponent),)*
                }
            }

            #[inline(always)]
            pub(crate) fn press(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Pressed<T> {
                match self {
                    $(Loss::$law(law) => law.press(spring, pressing, memory),)*
                }
            }

            #[inline(always)]
            pub(crate) fn curvature(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Curvature<T> {
                match self {
                    $(Loss::$law(law) => law.curvature(spring, pressing, memory),)*
                }
            }

            #[inline(always)]
            pub(crate) fn load_state(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Memory<T> {
                match self {
                    $(Loss::$law(law) => law.load_state(spring, pressing, memory),)*
                }
            }

            #[inline(always)]
            pub(crate) fn relax(&self, timing: &Timing<T>, memory: &Memory<T>) -> Memory<T> {
                match self {
                    $(Loss::$law(law) => law.relax(timing, memory),)*
                }
            }

            #[inline(always)]
            pub(crate) fn stored_energy(&self, spring: &Spring<T>, compression: T, memory: &Memory<T>) -> T {
                match self {
                    $(Loss::$law(law) => law.stored_energy(spring, compression, memory),)*
                }
            }
        }
    };
}

laws! {
    /// The papers' law.
    Quadratic
    /// Hunt and Crossley's.
    HuntCrossley
    /// Dry, and locked while it is held.
    SetValued
    /// Dry, by one slider in series with a spring.
    Elastoplastic
    /// Stulov's.
    Hereditary
    /// Dry, by sliders in parallel.
    Iwan
}

impl<T: Real> Default for Loss<T> {
    fn default() -> Self {
        Loss::none()
    }
}

impl<T: Real> Loss<T> {
    /// No loss.
    pub fn none() -> Self {
        Loss::quadratic(T::ZERO)
    }

    /// Its table of numbers.
    pub fn table(&self) -> &'static [LawNumber] {
        LAWS[self.law()]
    }

    /// Whether it loses energy.
    pub fn is_lossy(&self) -> bool {
        self.table().iter().zip(self.numbers()).any(|(number, x)| number.is_loss && T::ZERO.lt(x).any())
    }

    /// Viscosity of its rate part at a compression g that the spring resists with k g^r, N s/m.
    pub fn viscous(&self, compression: T, spring_force: T) -> T {
        match self.rate_part() {
            Form::Square(b) => b * compression * compression,
            Form::Proportional(a) => a * spring_force,
        }
    }

    /// This law with another type of number; `f` receives the numbers of its table, in their order.
    pub fn map<U: Real>(&self, mut f: impl FnMut(T) -> U) -> Loss<U> {
        let (mut mapped, numbers) = ([U::ZERO; LAW_NUMBERS], self.numbers());
        for (new, old) in mapped.iter_mut().zip(numbers).take(self.table().len()) {
            *new = f(old);
        }
        Loss::with(self.law(), mapped).unwrap_or(Loss::none())
    }

    /// The losses of all lanes; their law is the first one's.
    pub(crate) fn of_lanes<S: Scalar>(loss: impl Fn(usize) -> Loss<S>) -> Self {
        let numbers = core::array::from_fn(|k| join(|lane| loss(lane).numbers()[k]));
        Loss::with(loss(0).law(), numbers).unwrap_or(Loss::none())
    }
}

impl<T> Loss<T> {
    /// The papers' law with b, N s/m3.
    pub const fn quadratic(damping: T) -> Self
    where
        T: Copy,
    {
        Loss::Quadratic(Quadratic { damping })
    }

    /// Hunt and Crossley's law with a, s/m.
    pub const fn hunt_crossley(rate: T) -> Self
    where
        T: Copy,
    {
        Loss::HuntCrossley(HuntCrossley { rate })
    }
}
