//! The look of each material.

use crate::picture::{Gradient, Look, Paint};
use erard::instrument::Material;
use serde::Deserialize;

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

/// The gradients of all finishes, in their order: lit from above.
pub(crate) const GRADIENTS: &[Gradient] = &[
    lit("wood", "#ecd3a8", "#d3ac77"),
    lit("dark-wood", "#8f6a4b", "#6c4a31"),
    lit("felt", "#f6f0e2", "#ded3bc"),
    lit("cloth", "#b8414a", "#922c35"),
    lit("leather", "#b3aca2", "#8d867d"),
    lit("metal", "#d3d9de", "#929ba3"),
    lit("lead", "#868c92", "#62686e"),
    lit("ivory", "#fdfbf4", "#ece4d0"),
    lit("string", "#b9a778", "#857346"),
    lit("ebony", "#4a4642", "#2b2825"),
    lit("skin", "#f3d2bc", "#e2ae92"),
    lit("nail", "#fbe9e2", "#f0cfc3"),
    lit("symbol", "#cfdbe6", "#a3b7c9"),
];

/// The darker edges of all finishes, in their order.
const EDGES: [&str; 13] = [
    "#8a683c", "#452d1b", "#a3967b", "#611a21", "#5a554e", "#555e66", "#3c4146", "#8d8266", "#5b4d2b", "#171513",
    "#a4755c", "#b58a78", "#5f7589",
];

const fn lit(id: &'static str, upper: &'static str, lower: &'static str) -> Gradient {
    Gradient { id, upper, lower }
}

/// The look of a finish: lit from above, with a darker edge.
pub(crate) fn looks(finish: Finish) -> Vec<Look> {
    let index = finish as usize;
    vec![Look::Fill(Paint::Gradient(GRADIENTS[index].id)), Look::Stroke(Paint::Colour(EDGES[index]))]
}
