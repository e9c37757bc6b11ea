//! The tests of the engine: one program, so that it is linked once.

mod adaptive;
mod architecture;
mod description;
mod drives;
mod imports;
mod left_out;
mod regularised;
mod statics;
mod tangent;
mod workspace;
mod yielding;
