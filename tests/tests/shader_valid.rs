//! Every shader composes with what it imports, and is valid WGSL.

use engine::render::shaders;
use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_shader_is_valid() {
    let library = shaders::library().unwrap();
    let mut errors = Vec::new();
    let variants = shaders::PASSES
        .into_iter()
        .flat_map(|source| shaders::defines(source.name).into_iter().map(move |defines| (source, defines)));
    for (source, defines) in variants {
        match library.compose_with(source, &defines) {
            Ok(module) => {
                let mut validator = Validator::new(ValidationFlags::all(), Capabilities::CUBE_ARRAY_TEXTURES);
                if let Err(error) = validator.validate(&module) {
                    errors.push(format!("{} {defines:?}: {}", source.name, error.into_inner()));
                }
            }
            Err(error) => errors.push(error.to_string()),
        }
    }
    assert!(errors.is_empty(), "{}", errors.join("\n"));
}

#[test]
fn no_shader_file_is_forgotten() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let mut files = Vec::new();
    for folder in [folder.clone(), folder.join("scene"), folder.join("transport")] {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        files.extend(entries.filter(|path| path.extension().is_some_and(|ending| ending == "wgsl")));
    }
    assert_eq!(files.len(), shaders::IMPORTED.len() + shaders::PASSES.len());
}
