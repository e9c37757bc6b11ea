//! What each material looks like.

use crate::svg::escape;
use erard::instrument::Material;
use std::fmt::Write;

/// How a material is painted: lit from above, with a darker edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Paint {
    /// Identifier of the gradient, and class of the shapes.
    pub id: &'static str,
    /// Colour at the upper side.
    pub light: &'static str,
    /// Colour at the lower side.
    pub shade: &'static str,
    /// Colour of the outline.
    pub edge: &'static str,
}

/// All materials, in the order their gradients are written.
pub const ALL: [Material; 9] = [
    Material::Wood,
    Material::DarkWood,
    Material::Felt,
    Material::Cloth,
    Material::Leather,
    Material::Metal,
    Material::Lead,
    Material::Ivory,
    Material::String,
];

/// The look of a material.
pub const fn paint(material: Material) -> Paint {
    let (id, light, shade, edge) = match material {
        Material::Wood => ("wood", "#ecd3a8", "#d3ac77", "#8a683c"),
        Material::DarkWood => ("dark-wood", "#8f6a4b", "#6c4a31", "#452d1b"),
        Material::Felt => ("felt", "#f6f0e2", "#ded3bc", "#a3967b"),
        Material::Cloth => ("cloth", "#b8414a", "#922c35", "#611a21"),
        Material::Leather => ("leather", "#b3aca2", "#8d867d", "#5a554e"),
        Material::Metal => ("metal", "#d3d9de", "#929ba3", "#555e66"),
        Material::Lead => ("lead", "#868c92", "#62686e", "#3c4146"),
        Material::Ivory => ("ivory", "#fdfbf4", "#ece4d0", "#8d8266"),
        Material::String => ("string", "#b9a778", "#857346", "#5b4d2b"),
    };
    Paint { id, light, shade, edge }
}

/// The gradients of all materials, for a document's `<defs>`.
pub fn gradients() -> String {
    let mut out = String::new();
    for paint in ALL.map(paint) {
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
