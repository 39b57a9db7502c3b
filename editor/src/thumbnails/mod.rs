//! Small pictures of models, pictures and materials, for lists and slots.
//!
//! Whoever shows one asks for it with every picture of the editor, and gets it when it is there. Files are read on one thread,
//! scenes are drawn on another by a renderer of their own; what nobody shows any more is not begun, and what was not shown
//! for long is forgotten.

mod paint;
mod shrink;
mod work;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use eframe::egui::{Context, Rect, TextureHandle, TextureId, TextureOptions, vec2};
use engine::gpu::Gpu;
use engine::scene::assets::Assets;
use engine::scene::{ImageSource, Material, MaterialId};

use work::{Work, Workers};

/// Pixels of a side.
pub const SIDE: u32 = 128;
/// More are not kept.
const MOST: usize = 600;
/// Textures made of results in one picture of the editor.
const MOST_A_PICTURE: usize = 4;

/// What there is a small picture of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// A file of the project.
    Model(String),
    Picture(ImageSource),
    Material(MaterialId),
}

struct Known {
    /// `None`: it could not be made.
    texture: Option<TextureHandle>,
    /// As it was when it was drawn.
    material: Option<Material>,
    shown: u64,
}

#[derive(Default)]
pub struct Thumbnails {
    known: HashMap<Subject, Known>,
    /// In this picture of the editor, in the order in which they were asked for.
    wanted: Vec<Work>,
    workers: Option<Workers>,
    project: PathBuf,
    assets: Arc<Assets>,
    /// Counts pictures of the editor.
    picture: u64,
    /// What was made so far.
    pub made: u64,
}

/// Where in a rectangle a picture is shown whole.
pub fn fitted(ctx: &Context, rect: Rect, texture: TextureId) -> Rect {
    let size = ctx.tex_manager().read().meta(texture).map_or([1, 1], |meta| meta.size);
    let [width, height] = size.map(|side| side.max(1) as f32);
    let scale = (rect.width() / width).min(rect.height() / height);
    Rect::from_center_size(rect.center(), vec2(width * scale, height * scale))
}

impl Thumbnails {
    /// Before panels are drawn: what these are of.
    pub fn begin(&mut self, project: &Path, assets: &Arc<Assets>) {
        if self.project != project {
            self.known.clear();
            self.project = project.to_owned();
        }
        if !Arc::ptr_eq(&self.assets, assets) {
            self.assets = assets.clone();
        }
        self.picture += 1;
    }

    pub fn model(&mut self, file: &str) -> Option<TextureId> {
        let subject = Subject::Model(file.to_owned());
        self.shown(&subject, None).unwrap_or_else(|| {
            self.wanted.push(Work::Model { subject, project: self.project.clone(), file: file.to_owned() });
            None
        })
    }

    pub fn picture(&mut self, image: &ImageSource) -> Option<TextureId> {
        let subject = Subject::Picture(image.clone());
        self.shown(&subject, None).unwrap_or_else(|| {
            let held = self.assets.images.get(image).cloned();
            self.wanted.push(Work::Picture {
                subject,
                project: self.project.clone(),
                image: image.clone(),
                held,
            });
            None
        })
    }

    /// The last one is shown until the material's own is drawn.
    pub fn material(&mut self, material: &Material) -> Option<TextureId> {
        let subject = Subject::Material(material.id);
        if let Some(shown) = self.shown(&subject, Some(material)) {
            return shown;
        }
        let old = self.known.get(&subject).and_then(|known| known.texture.as_ref().map(TextureHandle::id));
        let textures = crate::assets::textures(material);
        let held = |image: &ImageSource| Some((image.clone(), self.assets.images.get(image)?.clone()));
        let images = textures.into_iter().filter_map(|texture| held(&texture.image)).collect();
        self.wanted.push(Work::Material { subject, material: Box::new(material.clone()), images });
        old
    }

    /// `None`: it has to be made.
    fn shown(&mut self, subject: &Subject, material: Option<&Material>) -> Option<Option<TextureId>> {
        let known = self.known.get_mut(subject)?;
        known.shown = self.picture;
        let is_current = material.is_none() || known.material.as_ref() == material;
        is_current.then(|| known.texture.as_ref().map(TextureHandle::id))
    }

    /// Of a file that is another now, or gone, and of what lies in it.
    pub fn forget(&mut self, file: &str) {
        self.known.retain(|subject, _| match subject {
            Subject::Model(other) => other != file,
            Subject::Picture(image) => image.file != file,
            Subject::Material(_) => true,
        });
    }

    /// After panels are drawn: what they lacked is asked for, what is done is taken.
    pub fn end(&mut self, ctx: &Context, gpu: &Arc<Gpu>) {
        let wanted = std::mem::take(&mut self.wanted);
        if self.workers.is_none() && wanted.is_empty() {
            return;
        }
        let workers = self.workers.get_or_insert_with(|| Workers::start(ctx.clone(), gpu.clone()));
        if !workers.ask(wanted) {
            ctx.request_repaint();
        }
        for done in workers.done(MOST_A_PICTURE) {
            let name = format!("{:?}", done.subject);
            let texture = done.image.map(|image| ctx.load_texture(name, image, TextureOptions::LINEAR));
            let known = Known { texture, material: done.material, shown: self.picture };
            self.known.insert(done.subject, known);
            self.made += 1;
            ctx.request_repaint();
        }
        self.drop_oldest();
    }

    fn drop_oldest(&mut self) {
        if self.known.len() <= MOST {
            return;
        }
        let mut shown: Vec<u64> = self.known.values().map(|known| known.shown).collect();
        shown.sort_unstable();
        let least = shown[shown.len() - MOST];
        self.known.retain(|_, known| known.shown >= least);
    }
}
