//! Pieces played on a few keys, and what became of their notes.

mod common;
mod files;
mod notes;
mod pedals;
mod performances;
mod rows;
mod scans;
