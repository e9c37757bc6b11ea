//! What can be seen of a mechanism from outside.

pub use moreau_kernels::{Meeting, Visible};
