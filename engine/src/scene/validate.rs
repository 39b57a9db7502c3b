//! What a scene has to be before anything is made of it: names that are one's own, references that lead
//! somewhere, numbers that are numbers, and no negative light. Each error says what to do.

use std::collections::{HashMap, HashSet};

use glam::Vec3;

use super::{
    Alpha, Changes, Entity, EntityId, Light, LightKind, Material, MaterialId, MeshRenderer, Motion,
    ReflectionProbe, Scene, SceneError, Sky, SkyKind, Texture, Transform,
};

/// Rotations have length 1, up to what a hand that types them rounds.
const UNIT: f64 = 1e-2;
/// Of lights [W/sr, W/m2] and of what surfaces and sky give [W/m2/sr]: above it, what bounces or falls on what is near
/// would be no float.
const BRIGHTEST: f32 = 1e26;

pub(super) fn validate(scene: &Scene) -> Result<(), SceneError> {
    let mut known = Known { entities: HashMap::new(), materials: HashSet::new() };
    for material in &scene.materials {
        if !known.materials.insert(material.id) {
            return Err(of_material(
                material,
                format!("shares its id {} with another: give it one of its own", material.id.0),
            ));
        }
        check_material(material).map_err(|message| of_material(material, message))?;
    }
    for entity in &scene.entities {
        if let Some(other) = known.entities.insert(entity.id, entity) {
            let message =
                format!("shares its id {} with `{}`: give it one of its own", entity.id.0, other.name);
            return Err(of_entity(entity, message));
        }
    }
    for entity in &scene.entities {
        check_entity(entity, &known).map_err(|message| of_entity(entity, message))?;
    }
    check_ancestry(scene, &known)?;
    check_sky(&scene.sky, &known).map_err(|message| SceneError::Scene(format!("sky: {message}")))
}

struct Known<'a> {
    entities: HashMap<EntityId, &'a Entity>,
    materials: HashSet<MaterialId>,
}

fn of_entity(entity: &Entity, message: String) -> SceneError {
    SceneError::Entity { entity: entity.name.clone(), message }
}

fn of_material(material: &Material, message: String) -> SceneError {
    SceneError::Material { material: material.name.clone(), message }
}

fn check_entity(entity: &Entity, known: &Known) -> Result<(), String> {
    check_transform(&entity.transform)?;
    if let Some(parent) = entity.parent {
        exists(known, parent, "its parent")?;
    }
    if let Some(mesh) = &entity.mesh {
        check_mesh(mesh, known)?;
    }
    if let Some(light) = &entity.light {
        check_light(light)?;
    }
    if let Some(camera) = &entity.camera {
        camera.validate()?;
    }
    if let Some(probes) = &entity.light_probes {
        require(
            probes.positions.iter().all(|p| p.is_finite()),
            "a light probe's position is not finite: remove it",
        )?;
    }
    if let Some(probe) = &entity.reflection_probe {
        check_reflection_probe(probe)?;
    }
    entity.motion.as_ref().map_or(Ok(()), check_motion)
}

fn check_transform(transform: &Transform) -> Result<(), String> {
    require(transform.translation.is_finite(), "its position is not finite: type a new one")?;
    require(transform.scale.is_finite(), "its scale is not finite: type a new one")?;
    let length = transform.rotation.length();
    let is_unit = (length - 1.0).abs() <= UNIT; // false for NaN
    require(is_unit, &format!("its rotation is a quaternion of length {length}: it has to be 1"))
}

fn check_mesh(mesh: &MeshRenderer, known: &Known) -> Result<(), String> {
    if let Some(missing) = mesh.materials.iter().find(|id| !known.materials.contains(id)) {
        return Err(format!("its material {} is not in the scene: choose another", missing.0));
    }
    let reflection = &mesh.reflection;
    if let Some(anchor) = reflection.anchor {
        exists(known, anchor, "its reflection anchor")?;
    }
    for probe in reflection.probes.iter().flatten() {
        exists(known, *probe, "a reflection probe that it uses")?;
    }
    require(reflection.strength.is_finite(), "the strength of its reflections is not finite")
}

fn check_light(light: &Light) -> Result<(), String> {
    require(is_light(light.color), "its light's colour has to be finite and not negative")?;
    require(is_amount(light.intensity), "its light's intensity has to be finite and not negative")?;
    require(
        is_light(light.color * light.intensity) && (light.color * light.intensity).max_element() <= BRIGHTEST,
        "its light is brighter than numbers go, 1e26 W/sr: the sun gives 3e25",
    )?;
    require(
        light.range.is_none_or(|range| range > 0.0),
        "its light's range has to be larger than 0, or none",
    )?;
    if let Some(switching) = &light.switching {
        switching.validate()?;
        require(
            light.changes != Changes::Never,
            "its light never changes, but switches: let it change, or remove its switching",
        )?;
    }
    let LightKind::Spot { inner, outer } = light.kind else { return Ok(()) };
    let is_cone = inner >= 0.0 && inner <= outer && outer <= std::f32::consts::FRAC_PI_2 + 1e-6;
    require(is_cone, "its spot's angles have to be 0 <= inner <= outer <= 90 degrees")
}

fn check_reflection_probe(probe: &ReflectionProbe) -> Result<(), String> {
    let box_is_one = is_light(probe.half_size) && probe.offset.is_finite();
    require(box_is_one, "its reflection probe's box has to be finite and not negative")?;
    require(
        is_amount(probe.blend_distance),
        "its reflection probe's blend distance has to be finite and not negative",
    )?;
    require(
        probe.near > 0.0 && probe.near.is_finite(),
        "its reflection probe's near plane has to be larger than 0",
    )?;
    require(
        (1..=4096).contains(&probe.resolution),
        "its reflection probe's resolution has to be 1 to 4096 pixels",
    )
}

fn check_motion(motion: &Motion) -> Result<(), String> {
    let is_finite = match motion {
        Motion::Spin { axis, radians_per_second } => axis.is_finite() && radians_per_second.is_finite(),
        Motion::PingPong { points, seconds, .. } => {
            points.iter().all(|p| p.is_finite()) && seconds.is_finite()
        }
        Motion::Clip { speed, .. } => speed.is_finite(),
    };
    require(is_finite, "its motion holds numbers that are not finite: type new ones")
}

/// Nobody is their own ancestor, and nothing that is static is carried about.
fn check_ancestry(scene: &Scene, known: &Known) -> Result<(), SceneError> {
    // What moves an entity: itself or the nearest ancestor with a motion. Known after the first visit.
    let mut mover: HashMap<EntityId, Option<EntityId>> = HashMap::new();
    for entity in &scene.entities {
        let mut chain: Vec<&Entity> = Vec::new();
        let mut on_chain = HashSet::new();
        let mut next = Some(entity);
        while let Some(one) = next.filter(|one| !mover.contains_key(&one.id)) {
            if !on_chain.insert(one.id) {
                return Err(of_entity(one, "is its own ancestor: give it another parent".to_owned()));
            }
            chain.push(one);
            next = one.parent.and_then(|parent| known.entities.get(&parent).copied());
        }
        let mut above = next.and_then(|one| mover[&one.id]);
        for one in chain.into_iter().rev() {
            above = if one.motion.is_some() { Some(one.id) } else { above };
            mover.insert(one.id, above);
        }
        if let Some(moves) = mover[&entity.id].filter(|_| entity.is_static) {
            return Err(of_entity(entity, carried(entity, known.entities[&moves])));
        }
    }
    Ok(())
}

fn carried(entity: &Entity, mover: &Entity) -> String {
    if entity.id == mover.id {
        "is static and has a motion: make it not static, or remove its motion".to_owned()
    } else {
        format!(
            "is static and is carried by `{0}`: make it not static, or remove the motion of `{0}`",
            mover.name
        )
    }
}

fn check_material(material: &Material) -> Result<(), String> {
    let Material { albedo, emission, metallic, roughness, normal_scale, opacity, .. } = material;
    require(albedo.color.is_finite(), "its albedo is not finite: type a new one")?;
    require(is_light(emission.color), "its emission's colour has to be finite and not negative")?;
    require(is_amount(emission.strength), "its emission's strength has to be finite and not negative")?;
    let radiance = emission.radiance();
    require(
        is_light(radiance) && radiance.max_element() <= BRIGHTEST,
        "its emission is too strong: at most 1e26 W/m2/sr",
    )?;
    let cutoff = if let Alpha::Mask { cutoff } = material.alpha { cutoff } else { 0.0 };
    let factors = [*metallic, *roughness, *normal_scale, *opacity, cutoff];
    require(
        factors.iter().all(|factor| factor.is_finite()),
        "one of its factors is not finite: type a new one",
    )?;
    let textures =
        [&albedo.texture, &material.metallic_roughness_texture, &material.normal_texture, &emission.texture];
    require(
        textures.into_iter().flatten().all(is_placed),
        "a texture's offset, rotation or scale is not finite",
    )
}

fn is_placed(texture: &Texture) -> bool {
    texture.offset.is_finite() && texture.scale.is_finite() && texture.rotation.is_finite()
}

fn check_sky(sky: &Sky, known: &Known) -> Result<(), String> {
    const RADIANCE: &str = "its radiance has to be finite, not negative and at most 1e26";
    let is_light = |radiance: Vec3| is_light(radiance) && radiance.max_element() <= BRIGHTEST;
    match &sky.kind {
        SkyKind::None => Ok(()),
        SkyKind::Constant { radiance } => require(is_light(*radiance), RADIANCE),
        SkyKind::Gradient { zenith, horizon, ground, sun, sun_diameter } => {
            require([zenith, horizon, ground].into_iter().all(|radiance| is_light(*radiance)), RADIANCE)?;
            require(is_amount(*sun_diameter), "the sun's diameter has to be finite and not negative")?;
            sun.map_or(Ok(()), |sun| exists(known, sun, "its sun"))
        }
        SkyKind::Picture { strength, turn, .. } => {
            require(
                is_amount(*strength) && *strength <= BRIGHTEST,
                "its strength has to be finite and not negative",
            )?;
            require(turn.is_finite(), "its turn is not finite")
        }
    }
}

fn exists(known: &Known, id: EntityId, what: &str) -> Result<(), String> {
    require(
        known.entities.contains_key(&id),
        &format!("{what} (entity {}) is not in the scene: choose another", id.0),
    )
}

fn require(holds: bool, message: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(message.to_owned()) }
}

fn is_light(spectrum: Vec3) -> bool {
    spectrum.is_finite() && spectrum.min_element() >= 0.0
}

fn is_amount(value: f32) -> bool {
    value.is_finite() && value >= 0.0
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::scene::shape::Shape;
    use crate::scene::{Camera, Density, LightProbeGroup, MeshSource, Reflection};

    /// A parent 1 with a static child 2 that draws a cube of material 7.
    fn sound() -> Scene {
        let mesh = MeshRenderer {
            mesh: MeshSource::Shape(Shape::Cube),
            materials: vec![MaterialId(7)],
            casts_shadows: true,
            density: Density::default(),
            reflection: Reflection::default(),
        };
        let entity =
            |id: u64, name: &str| Entity { id: EntityId(id), name: name.to_owned(), ..Entity::default() };
        let child =
            Entity { parent: Some(EntityId(1)), is_static: true, mesh: Some(mesh), ..entity(2, "child") };
        let material = Material { id: MaterialId(7), name: "paint".to_owned(), ..Material::default() };
        Scene { materials: vec![material], entities: vec![entity(1, "parent"), child], ..Scene::default() }
    }

    #[test]
    fn a_sound_scene_passes() {
        sound().validate().unwrap();
        Scene::default().validate().unwrap();
    }

    #[test]
    fn what_is_wrong_is_named_with_a_remedy() {
        let light = |change: fn(&mut Light)| {
            let mut light = Light::default();
            change(&mut light);
            Some(light)
        };
        let spin = || Some(Motion::Spin { axis: DVec3::Y, radians_per_second: 1.0 });
        type Damage = Box<dyn Fn(&mut Scene)>;
        let damages: Vec<(&str, Damage)> = vec![
            ("`child`: shares its id 1 with `parent`", Box::new(|s| s.entities[1].id = EntityId(1))),
            ("`paint`: shares its id", Box::new(|s| s.materials.push(s.materials[0].clone()))),
            ("`child`: its parent (entity 9)", Box::new(|s| s.entities[1].parent = Some(EntityId(9)))),
            ("own ancestor", Box::new(|s| s.entities[0].parent = Some(EntityId(2)))),
            ("`parent`: is its own ancestor", Box::new(|s| s.entities[0].parent = Some(EntityId(1)))),
            ("`child`: its material 7", Box::new(|s| s.materials.clear())),
            (
                "anchor (entity 8)",
                Box::new(|s| s.entities[1].mesh.as_mut().unwrap().reflection.anchor = Some(EntityId(8))),
            ),
            (
                "probe that it uses",
                Box::new(|s| {
                    s.entities[1].mesh.as_mut().unwrap().reflection.probes = Some(vec![EntityId(8)])
                }),
            ),
            ("`child`: its position", Box::new(|s| s.entities[1].transform.translation.x = f64::NAN)),
            ("`child`: its scale", Box::new(|s| s.entities[1].transform.scale.x = f64::INFINITY)),
            ("of length 0", Box::new(|s| s.entities[1].transform.rotation = DQuat::from_array([0.0; 4]))),
            ("of length NaN", Box::new(|s| s.entities[1].transform.rotation.x = f64::NAN)),
            (
                "`parent`: its light's colour",
                Box::new(move |s| s.entities[0].light = light(|l| l.color.y = -1.0)),
            ),
            ("light's intensity", Box::new(move |s| s.entities[0].light = light(|l| l.intensity = -1.0))),
            ("light's range", Box::new(move |s| s.entities[0].light = light(|l| l.range = Some(f32::NAN)))),
            (
                "spot's angles",
                Box::new(move |s| {
                    s.entities[0].light = light(|l| l.kind = LightKind::Spot { inner: 1.0, outer: 0.5 })
                }),
            ),
            (
                "near plane",
                Box::new(|s| s.entities[0].camera = Some(Camera { near: -1.0, ..Camera::default() })),
            ),
            (
                "light probe",
                Box::new(|s| {
                    s.entities[0].light_probes = Some(LightProbeGroup { positions: vec![Vec3::NAN] })
                }),
            ),
            (
                "probe's box",
                Box::new(|s| {
                    s.entities[0].reflection_probe =
                        Some(ReflectionProbe { half_size: -Vec3::ONE, ..Default::default() })
                }),
            ),
            ("`child`: is static and has a motion", Box::new(move |s| s.entities[1].motion = spin())),
            (
                "`child`: is static and is carried by `parent`",
                Box::new(move |s| s.entities[0].motion = spin()),
            ),
            (
                "its motion",
                Box::new(|s| {
                    s.entities[0].motion =
                        Some(Motion::PingPong { points: vec![], seconds: f64::NAN, look: false })
                }),
            ),
            ("`paint`: its emission's colour", Box::new(|s| s.materials[0].emission.color = -Vec3::X)),
            (
                "too strong",
                Box::new(|s| {
                    (s.materials[0].emission.color, s.materials[0].emission.strength) = (Vec3::MAX, 2.0)
                }),
            ),
            ("sky: its radiance", Box::new(|s| s.sky.kind = SkyKind::Constant { radiance: -Vec3::ONE })),
            (
                "sky: its sun (entity 5)",
                Box::new(|s| {
                    s.sky.kind = SkyKind::Gradient {
                        zenith: Vec3::ONE,
                        horizon: Vec3::ONE,
                        ground: Vec3::ONE,
                        sun: Some(EntityId(5)),
                        sun_diameter: 0.0,
                    }
                }),
            ),
        ];
        for (expected, damage) in damages {
            let mut scene = sound();
            damage(&mut scene);
            let message = scene.validate().expect_err(expected).to_string();
            assert!(message.contains(expected), "`{message}` does not say `{expected}`");
        }
    }
}
