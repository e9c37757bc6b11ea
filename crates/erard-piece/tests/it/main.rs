//! Pieces played on a few keys, and what became of their notes.

mod notes;
