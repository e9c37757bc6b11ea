//! The look of each material.

use crate::svg::escape;
use erard::instrument::Material;
use serde::Deserialize;
use std::fmt::Write;

/// How a finish is painted: lit from above, with a darker edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Paint {
    /// Identifier of the gradient, and class of the shapes.
    pub id: &'static str,
    /// Colour at the upper side.
    pub light: &'static str,
    /// Colour at the lower side.
    pub shade: &'static str,
    /// Colour of the outline.
    pub edge: &'static str,
}

/// Appearance of an outline: a material of instrument files, or one that only pictures have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finish {
    /// Key sticks, whippens, shanks, mouldings.
    Wood,
    /// Rails and other wood that does not move.
    DarkWood,
    /// Felt.
    Felt,
    /// Bushing and rail cloth.
    Cloth,
    /// Leather.
    Leather,
    /// Capstans, screws, wires.
    Metal,
    /// Leads in the key.
    Lead,
    /// Key tops.
    Ivory,
    /// The string.
    String,
    /// Sharps.
    Ebony,
    /// The finger.
    Skin,
    /// Its nail.
    Nail,
    /// Symbol of a quantity: the inertia of a model with one body.
    Symbol,
}

impl From<Material> for Finish {
    fn from(material: Material) -> Self {
        match material {
            Material::Wood => Finish::Wood,
            Material::DarkWood => Finish::DarkWood,
            Material::Felt => Finish::Felt,
            Material::Cloth => Finish::Cloth,
            Material::Leather => Finish::Leather,
            Material::Metal => Finish::Metal,
            Material::Lead => Finish::Lead,
            Material::Ivory => Finish::Ivory,
            Material::String => Finish::String,
        }
    }
}

/// The looks of all finishes, in their order.
const PAINTS: [Paint; 13] = [
    look("wood", "#ecd3a8", "#d3ac77", "#8a683c"),
    look("dark-wood", "#8f6a4b", "#6c4a31", "#452d1b"),
    look("felt", "#f6f0e2", "#ded3bc", "#a3967b"),
    look("cloth", "#b8414a", "#922c35", "#611a21"),
    look("leather", "#b3aca2", "#8d867d", "#5a554e"),
    look("metal", "#d3d9de", "#929ba3", "#555e66"),
    look("lead", "#868c92", "#62686e", "#3c4146"),
    look("ivory", "#fdfbf4", "#ece4d0", "#8d8266"),
    look("string", "#b9a778", "#857346", "#5b4d2b"),
    look("ebony", "#4a4642", "#2b2825", "#171513"),
    look("skin", "#f3d2bc", "#e2ae92", "#a4755c"),
    look("nail", "#fbe9e2", "#f0cfc3", "#b58a78"),
    look("symbol", "#cfdbe6", "#a3b7c9", "#5f7589"),
];

const fn look(id: &'static str, light: &'static str, shade: &'static str, edge: &'static str) -> Paint {
    Paint { id, light, shade, edge }
}

/// The look of a finish.
pub(crate) const fn paint(finish: Finish) -> Paint {
    PAINTS[finish as usize]
}

/// The gradients of all finishes, for a document's `<defs>`.
pub(crate) fn gradients() -> String {
    let mut out = String::new();
    for paint in PAINTS {
        let _ = write!(
            out,
            "<linearGradient id=\"{id}\" x1=\"0\" y1=\"0\" x2=\"0\" y2=\"1\"><stop offset=\"0\" stop-color=\"{}\"/>\
             <stop offset=\"1\" stop-color=\"{}\"/></linearGradient>",
            paint.light,
            paint.shade,
            id = escape(paint.id),
        );
    }
    out
}
