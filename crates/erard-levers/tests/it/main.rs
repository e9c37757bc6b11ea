//! The tests of the three levers: one program, so that it is linked once.

mod levers;
