//! One component of all that is selected: what they have in common, and edits that set it for all of them.

use std::rc::Rc;

use eframe::egui;
use egui::{Checkbox, ComboBox, Ui};
use engine::scene::{Entity, EntityId};
use glam::DVec3;

use super::component::{self, Wish};
use super::fields::{self, Number, Touched};
use crate::ask::Asks;
use crate::edit::{Edit, Field};
use crate::intents::Intent;

type EditOf<K, C> = Box<dyn Fn(Vec<(K, C)>) -> Edit>;

pub struct Subject<'a, K, C> {
    items: Vec<(K, &'a C)>,
    edit: EditOf<K, C>,
    /// As a whole, where it is a component of entities.
    field: Option<Rc<dyn Fn(C) -> Field>>,
    /// What fields are reset to.
    usual: Option<C>,
    asks: &'a mut Asks,
}

impl<'a, C: Clone + 'static> Subject<'a, EntityId, C> {
    /// A component of those entities that have it.
    pub fn component(
        entities: &[&'a Entity],
        get: impl Fn(&'a Entity) -> Option<&'a C>,
        field: impl Fn(C) -> Field + 'static,
        asks: &'a mut Asks,
    ) -> Self {
        let items = entities.iter().filter_map(|entity| Some((entity.id, get(entity)?))).collect();
        let field: Rc<dyn Fn(C) -> Field> = Rc::new(field);
        let whole = field.clone();
        let edit = move |items: Vec<(EntityId, C)>| {
            Edit::Set(items.into_iter().map(|(id, component)| (id, field(component))).collect())
        };
        Self { items, edit: Box::new(edit), field: Some(whole), usual: None, asks }
    }

    /// All of them lose it; `none` is the field without it.
    pub fn remove(&mut self, none: Field) {
        self.set_whole("Remove component", none);
    }

    fn set_whole(&mut self, name: &str, value: Field) {
        let fields = self.items.iter().map(|(id, _)| (*id, value.clone()));
        self.asks.push(Intent::Commit(Edit::several(name, [Edit::Set(fields.collect())])));
    }

    /// The first one, as a whole.
    fn whole(&self) -> Option<Field> {
        Some(self.field.as_ref()?(self.first()?.clone()))
    }

    /// Was one of its kind copied?
    pub fn can_paste(&self, ui: &Ui) -> bool {
        let kind = |field: &Field| std::mem::discriminant(field);
        component::copied(ui).zip(self.whole()).is_some_and(|(copied, own)| kind(&copied) == kind(&own))
    }

    /// What was chosen from the component's menu. `none`: the field without it.
    pub fn fulfil(&mut self, ui: &Ui, wish: Option<Wish>, none: Field) {
        match wish {
            Some(Wish::Copy) => component::copy(ui, self.whole()),
            Some(Wish::Paste) => {
                if let Some(copied) = component::copied(ui) {
                    self.set_whole("Paste values", copied);
                }
            }
            Some(Wish::Reset) => {
                if let Some((field, usual)) = self.field.clone().zip(self.usual.clone()) {
                    self.set_whole("Reset component", field(usual));
                }
            }
            Some(Wish::Remove) => self.remove(none),
            None => {}
        }
    }
}

impl<'a, K: Clone, C: Clone> Subject<'a, K, C> {
    pub fn new(
        items: Vec<(K, &'a C)>,
        edit: impl Fn(Vec<(K, C)>) -> Edit + 'static,
        asks: &'a mut Asks,
    ) -> Self {
        Self { items, edit: Box::new(edit), field: None, usual: None, asks }
    }

    /// Fields are reset to this one's.
    pub fn usually(mut self, usual: C) -> Self {
        self.usual = Some(usual);
        self
    }

    /// Before fields that only some have: what they are reset to.
    pub fn usually_with(&mut self, change: impl FnOnce(&mut C)) {
        if let Some(usual) = &mut self.usual {
            change(usual);
        }
    }

    /// What a field is reset to. `None`: all of them have that, or nothing is known.
    pub fn reset_to<T: PartialEq>(&self, get: impl Fn(&C) -> T) -> Option<T> {
        let usual = get(self.usual.as_ref()?);
        self.items.iter().any(|(_, component)| get(component) != usual).then_some(usual)
    }

    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    pub fn first(&self) -> Option<&'a C> {
        self.items.first().map(|(_, component)| *component)
    }

    /// What all of them have; `None`: they differ.
    pub fn shared<T: PartialEq>(&self, get: impl Fn(&C) -> T) -> Option<T> {
        let mut values = self.items.iter().map(|(_, component)| get(component));
        let first = values.next()?;
        values.all(|value| value == first).then_some(first)
    }

    /// Sets it for all of them: at once, or until the pull at the field ends.
    pub fn set<T: Clone>(&mut self, touched: &Touched<T>, set: impl Fn(&mut C, T)) {
        if let Some(value) = &touched.value {
            let changed = self.items.iter().map(|(key, component)| {
                let mut new = (*component).clone();
                set(&mut new, value.clone());
                (key.clone(), new)
            });
            let edit = (self.edit)(changed.collect());
            self.asks.push(if touched.dragging { Intent::Preview(edit) } else { Intent::Commit(edit) });
        }
        if touched.ended {
            self.asks.push(Intent::End);
        }
    }

    pub fn set_now<T: Clone>(&mut self, value: T, set: impl Fn(&mut C, T)) {
        self.set(&Touched { value: Some(value), dragging: false, ended: false }, set);
    }

    pub fn number(
        &mut self,
        ui: &mut Ui,
        (name, tooltip): (&str, &str),
        number: &Number,
        get: impl Fn(&C) -> f64,
        set: impl Fn(&mut C, f64),
    ) {
        let (value, usual) = (self.shared(&get), self.reset_to(get));
        let width = |ui: &Ui| ui.available_width();
        let (touched, is_reset) = fields::resettable(ui, name, tooltip, usual.is_some(), |ui| {
            number.show(ui, name, value, width(ui)).1
        });
        self.set(&touched, &set);
        self.reset(usual, is_reset, set);
    }

    pub fn reset<T: Clone>(&mut self, usual: Option<T>, is_reset: bool, set: impl Fn(&mut C, T)) {
        if let Some(usual) = usual.filter(|_| is_reset) {
            self.set_now(usual, set);
        }
    }

    pub fn vector(
        &mut self,
        ui: &mut Ui,
        (name, tooltip): (&str, &str),
        number: &Number,
        get: impl Fn(&C) -> DVec3,
        set: impl Fn(&mut C, usize, f64),
    ) {
        let values = [0, 1, 2].map(|axis| self.shared(|component| get(component)[axis]));
        let usual = self.reset_to(&get);
        let (touched, is_reset) = fields::resettable(ui, name, tooltip, usual.is_some(), |ui| {
            fields::vector(ui, name, number, values)
        });
        for (axis, touched) in touched.iter().enumerate() {
            self.set(touched, |component, value| set(component, axis, value));
        }
        self.reset(usual, is_reset, |component, usual| {
            (0..3).for_each(|axis| set(component, axis, usual[axis]));
        });
    }

    /// A tick with its name behind it.
    pub fn tick(
        &mut self,
        ui: &mut Ui,
        (name, tooltip): (&str, &str),
        get: impl Fn(&C) -> bool,
        set: impl Fn(&mut C, bool),
    ) {
        let shared = self.shared(get);
        let mut on = shared.unwrap_or(false);
        let response = ui.add(Checkbox::new(&mut on, name).indeterminate(shared.is_none()));
        if response.on_hover_text(tooltip).changed() {
            self.set_now(on, set);
        }
    }

    /// A tick in a row of its own.
    pub fn toggle(
        &mut self,
        ui: &mut Ui,
        (name, tooltip): (&str, &str),
        get: impl Fn(&C) -> bool,
        set: impl Fn(&mut C, bool),
    ) {
        let (shared, usual) = (self.shared(&get), self.reset_to(get));
        let mut on = shared.unwrap_or(false);
        let (changed, is_reset) = fields::resettable(ui, name, tooltip, usual.is_some(), |ui| {
            let response = ui.add(Checkbox::without_text(&mut on).indeterminate(shared.is_none()));
            response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
            response.changed()
        });
        if changed {
            self.set_now(on, &set);
        }
        self.reset(usual, is_reset, set);
    }

    /// One of a few, by name.
    pub fn choice<T: PartialEq + Clone>(
        &mut self,
        ui: &mut Ui,
        (name, tooltip): (&str, &str),
        choices: &[(T, &str)],
        get: impl Fn(&C) -> T,
        set: impl Fn(&mut C, T),
    ) {
        let (shared, usual) = (self.shared(&get), self.reset_to(get));
        let said =
            |value: &T| choices.iter().find(|(choice, _)| choice == value).map_or("", |(_, name)| name);
        let mut chosen = None;
        let (_, is_reset) = fields::resettable(ui, name, tooltip, usual.is_some(), |ui| {
            let shown = ComboBox::from_id_salt(name)
                .selected_text(shared.as_ref().map_or("\u{2014}", said))
                .width(ui.available_width())
                .truncate()
                .show_ui(ui, |ui| {
                    for (choice, name) in choices {
                        if ui.selectable_label(shared.as_ref() == Some(choice), *name).clicked() {
                            chosen = Some(choice.clone());
                        }
                    }
                });
            let id = shown.response.id;
            ui.ctx().accesskit_node_builder(id, |node| node.set_label(name));
        });
        if let Some(chosen) = chosen {
            self.set_now(chosen, &set);
        }
        self.reset(usual, is_reset, set);
    }
}
