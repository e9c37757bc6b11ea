//! The tests of rigid bodies: one program, so that it is linked once.

mod piles;
mod rigid;
mod sticks;
