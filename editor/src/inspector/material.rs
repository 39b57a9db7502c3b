//! The materials of all that is selected. They are shared: a change shows wherever a material is used.

use eframe::egui::Ui;
use engine::scene::{Alpha, Entity, Material, MaterialId, Texture};

use super::arithmetic::Unit;
use super::colour;
use super::fields::{self, Number, section};
use super::light::CHANGES;
use super::subject::Subject;
use crate::ask::Asks;
use crate::document::Document;
use crate::edit::Edit;
use crate::icons::Icon;

/// Materials that are shown one by one, where what is selected has several.
const MOST: usize = 12;

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Opaque,
    Mask,
    Blend,
}

const KINDS: [(Kind, &str); 3] =
    [(Kind::Opaque, "Opaque"), (Kind::Mask, "With holes"), (Kind::Blend, "Transparent")];

fn kind(material: &Material) -> Kind {
    match material.alpha {
        Alpha::Opaque => Kind::Opaque,
        Alpha::Mask { .. } => Kind::Mask,
        Alpha::Blend => Kind::Blend,
    }
}

type Materials<'a> = Subject<'a, MaterialId, Material>;

/// Entities with a material each: all of these at once. Else each material by itself.
pub fn show(ui: &mut Ui, document: &Document, entities: &[&Entity], asks: &mut Asks) {
    let used = entities.iter().filter_map(|entity| entity.mesh.as_ref());
    let is_plain = used.clone().all(|mesh| mesh.materials.len() == 1);
    let mut ids: Vec<MaterialId> = used.flat_map(|mesh| mesh.materials.iter().copied()).collect();
    ids.sort();
    ids.dedup();
    let materials: Vec<&Material> = ids.iter().filter_map(|id| document.material(*id)).collect();
    match materials.as_slice() {
        [] => {}
        many if is_plain && many.len() > 1 => one(ui, &format!("{} materials", many.len()), many, asks),
        many => many.iter().take(MOST).for_each(|material| one(ui, &material.name, &[material], asks)),
    }
}

fn one(ui: &mut Ui, name: &str, materials: &[&Material], asks: &mut Asks) {
    let items = materials.iter().map(|material| (material.id, *material)).collect();
    let edit = |items: Vec<(MaterialId, Material)>| {
        Edit::SetMaterials(items.into_iter().map(|(_, material)| material).collect())
    };
    let mut of = Subject::new(items, edit, asks).usually(Material::default());
    // Several may have one name.
    ui.push_id(materials.first().map(|material| material.id.0), |ui| {
        section(ui, Icon::Material, name, None, |ui| fields_of(ui, &mut of));
    });
}

fn fields_of(ui: &mut Ui, of: &mut Materials<'_>) {
    colour::row(
        ui,
        of,
        ("Color", "Of light that it throws back, linear RGB"),
        |m| m.albedo.color,
        |m, color| {
            // More than all of the light comes back from nothing.
            m.albedo.color = color.clamp(glam::Vec3::ZERO, glam::Vec3::ONE);
        },
    );
    texture(ui, of, "Color picture", |m| m.albedo.texture.as_ref());
    let share = Number::share();
    of.number(
        ui,
        ("Metallic", "0: plaster, wood, plastic. 1: bare metal"),
        &share,
        |m| m.metallic.into(),
        |m, v| m.metallic = v as f32,
    );
    of.number(
        ui,
        ("Roughness", "0: a mirror. 1: chalk"),
        &share,
        |m| m.roughness.into(),
        |m, v| m.roughness = v as f32,
    );
    texture(ui, of, "Metal, roughness", |m| m.metallic_roughness_texture.as_ref());
    texture(ui, of, "Normals", |m| m.normal_texture.as_ref());
    if of.shared(|m| m.normal_texture.is_some()) == Some(true) {
        let depth = Number { most: 8.0, ..Number::share() };
        let tooltip = "How far its normals tilt: 1 as the picture says, 0 flat";
        of.number(
            ui,
            ("Bumps", tooltip),
            &depth,
            |m| m.normal_scale.into(),
            |m, v| m.normal_scale = v as f32,
        );
    }
    emission(ui, of);
    let set = |m: &mut Material, kind: Kind| {
        m.alpha = match kind {
            Kind::Opaque => Alpha::Opaque,
            Kind::Mask => Alpha::Mask { cutoff: 0.5 },
            Kind::Blend => Alpha::Blend,
        };
    };
    of.choice(ui, ("Surface", "Whether one sees through it"), &KINDS, kind, set);
    if of.shared(kind) == Some(Kind::Mask) {
        cutoff(ui, of, &share);
    }
    if of.shared(kind).is_some_and(|kind| kind != Kind::Opaque) {
        of.number(
            ui,
            ("Opacity", "Times that of its picture"),
            &share,
            |m| m.opacity.into(),
            |m, v| m.opacity = v as f32,
        );
    }
    of.toggle(ui, ("Double-sided", "Seen from behind too"), |m| m.double_sided, |m, on| m.double_sided = on);
    of.toggle(ui, ("Unlit", "Shown in its color, whatever the light"), |m| m.unlit, |m, on| m.unlit = on);
    let changes = "What of its color may change while the scene plays: the less, the cheaper";
    of.choice(ui, ("May change", changes), &CHANGES, |m| m.albedo.changes, |m, v| m.albedo.changes = v);
}

fn cutoff(ui: &mut Ui, of: &mut Materials<'_>, share: &Number) {
    let get = |m: &Material| match m.alpha {
        Alpha::Mask { cutoff } => f64::from(cutoff),
        _ => 0.5,
    };
    let set = |m: &mut Material, v: f64| m.alpha = Alpha::Mask { cutoff: v as f32 };
    of.number(ui, ("Cutoff", "What is less opaque is a hole"), share, get, set);
}

fn emission(ui: &mut Ui, of: &mut Materials<'_>) {
    colour::row(
        ui,
        of,
        ("Emission", "Color of light that it gives off"),
        |m| m.emission.color,
        |m, color| m.emission.color = color,
    );
    if of.shared(|m| m.emission.color == glam::Vec3::ZERO) == Some(true) {
        return;
    }
    let tooltip = "Radiance, W/m\u{b2}/sr, times its color";
    let number = Number::positive(Unit::None);
    of.number(
        ui,
        ("Strength", tooltip),
        &number,
        |m| m.emission.strength.into(),
        |m, v| m.emission.strength = v as f32,
    );
    texture(ui, of, "Emission picture", |m| m.emission.texture.as_ref());
    let sampled = "The bake aims at it: for small, bright lamps";
    of.toggle(ui, ("Aimed at", sampled), |m| m.emission.sampled, |m, on| m.emission.sampled = on);
    let changes = "What of its emission may change while the scene plays: the less, the cheaper";
    of.choice(
        ui,
        ("Glow may change", changes),
        &CHANGES,
        |m| m.emission.changes,
        |m, v| m.emission.changes = v,
    );
}

/// The picture's name, where there is one.
fn texture(ui: &mut Ui, of: &Materials<'_>, name: &str, get: fn(&Material) -> Option<&Texture>) {
    let Some(picture) = of.first().and_then(|material| get(material)) else { return };
    let source = format!("{:?}", picture.image);
    let shared = of.shared(|material| get(material).map(|texture| texture.image.clone())).is_some();
    fields::row(ui, name, &source, |ui| {
        let text = if shared { source.clone() } else { "\u{2014}".to_owned() };
        ui.add(eframe::egui::Label::new(text).truncate()).on_hover_text(&source);
    });
}
