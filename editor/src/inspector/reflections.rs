//! Which reflection probes a mesh shows: those around it, those around something else, or certain ones.

use eframe::egui::Ui;
use engine::scene::{Entity, EntityId};

use super::entity::{Question, field};
use super::mesh::Meshes;
use crate::document::Document;

/// Probes that are listed to be ticked.
const MOST: usize = 32;

pub fn show(ui: &mut Ui, of: &mut Meshes<'_>, document: &Document) {
    let question = Question {
        name: "Reflects as at",
        tooltip: "It shows the reflections of this object's place instead of its own",
        none: "Its own place",
        fits: |_| true,
    };
    let anchor = of.shared(|mesh| mesh.reflection.anchor);
    if let Some(chosen) = field(ui, &question, document, anchor) {
        of.set_now(chosen, |mesh, anchor| mesh.reflection.anchor = anchor);
    }
    let every = "All whose boxes hold it, or those that are ticked and no others";
    of.choice(
        ui,
        ("Probes", every),
        &[(false, "All around it"), (true, "Those ticked")],
        |mesh| mesh.reflection.probes.is_some(),
        |mesh, certain| mesh.reflection.probes = certain.then(Vec::new),
    );
    if of.shared(|mesh| mesh.reflection.probes.is_some()) == Some(true) {
        let probes = document.scene().entities.iter().filter(|entity| entity.reflection_probe.is_some());
        probes.take(MOST).for_each(|probe| tick(ui, of, probe));
    }
}

fn tick(ui: &mut Ui, of: &mut Meshes<'_>, probe: &Entity) {
    let id: EntityId = probe.id;
    of.toggle(
        ui,
        (&probe.name, "This reflection probe is shown"),
        |mesh| mesh.reflection.probes.as_ref().is_some_and(|probes| probes.contains(&id)),
        |mesh, on| {
            let probes = mesh.reflection.probes.get_or_insert_default();
            probes.retain(|other| *other != id);
            probes.extend(on.then_some(id));
        },
    );
}
