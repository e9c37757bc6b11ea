//! The outlines of a grand action, read from `assets/grand-outlines.toml`.

use std::sync::LazyLock;

use erard::instrument::Vec2;
use erard::instrument::from_toml::from_toml;
use serde::Deserialize;

use super::parts::Component;
use super::places::Place;
use crate::drawing::material::Finish;

/// One entry of the drawing.
#[derive(Debug, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub(super) enum Entry {
    /// An outline that hangs on places.
    Outline(Outline),
    /// A part that `made` draws.
    Made { made: Made },
}

/// An outline that hangs on places.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Outline {
    /// Name; one with a comma is a detail of a main part.
    pub name: String,
    pub on: Component,
    pub finish: Finish,
    /// Whether sharps alone have it, or naturals alone; both where nothing is said.
    pub of_sharps: Option<bool>,
    /// Whether corners are left as they are. Otherwise they are rounded off, but for those that are written twice; long
    /// edges stay straight.
    #[serde(default)]
    pub sharp: bool,
    /// Corners one after the other.
    pub corners: Vec<Corners>,
}

/// A place, and corners as offsets from it, mm.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Corners {
    pub at: Place,
    pub by: Vec<Vec2>,
}

/// What is round or varies in number, by the function of `made` that draws it.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Made {
    Capstan,
    DamperHead,
    Knuckle,
    Leads,
    Tail,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    outline: Vec<Entry>,
}

/// The drawing in painter's order: later entries cover earlier ones.
pub(super) fn drawing() -> &'static [Entry] {
    static DRAWING: LazyLock<Vec<Entry>> = LazyLock::new(|| {
        let file: File = from_toml(include_str!("../../../assets/grand-outlines.toml")).expect("it is built in");
        file.outline
    });
    &DRAWING
}
