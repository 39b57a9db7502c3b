// Surfaces: direct light from punctual lights with shadows, and what receivers (or light probes, for what
// moves) say of the rest. Lambert for diffuse light, so that pictures agree with the transport to the last
// digit; GGX (Walter et al. 2007, height-correlated Smith by Heitz 2014) with Schlick's Fresnel on top.
//
// What a scene does without is not even compiled. Defined are NORMAL_MAP, MASK, BLEND and UNLIT where the material is of
// that kind, LIGHTS where punctual lights shine, CUBEMAPS where there are any, GREY where light has one channel.
#import hohlraum::frame::{frame, to_eye, drawn, COMPOSITE, DIRECT, INDIRECT, REFLECTION, ALBEDO, NORMAL, HEADLIGHT, PROBES}
#import hohlraum::scene::mesh::{Still, Moving, moved, moved_normal, moved_tangent}
#import hohlraum::scene::material::{material, base_color, metal, emission_at, is}
#ifdef MASK
#import hohlraum::scene::material::MASKED
#endif
#ifdef BLEND
#import hohlraum::scene::material::BLENDED
#endif
#ifdef UNLIT
#import hohlraum::scene::material::SHINING
#endif
#ifdef NORMAL_MAP
#import hohlraum::scene::material::{bump, mapped}
#import hohlraum::transport::directional::tilted
#endif
#ifdef LIGHTS
#import hohlraum::scene::material::DOUBLE_SIDED
#import hohlraum::scene::light::{lights_at, light_of, arrival, visible_in_view}
#endif
#ifdef CUBEMAPS
#import hohlraum::scene::reflection::around
#endif
#import hohlraum::scene::reflection::{reflectance, use_of}
#import hohlraum::transport::channels::{Stored, value_of, in_full}
#import hohlraum::transport::sh

/// Irradiance at receivers [W/m2]: seen unblocked from emitters and sky, and all that bounced. From
/// `frame.directional` on: the directional terms of the first ones, along x, y and z.
@group(2) @binding(0) var<storage, read> receivers_direct: array<Stored>;
@group(2) @binding(1) var<storage, read> receivers_indirect: array<Stored>;
/// Nine coefficients an object that moves, likewise.
@group(2) @binding(2) var<storage, read> objects_direct: array<Stored>;
@group(2) @binding(3) var<storage, read> objects_indirect: array<Stored>;

const PI: f32 = 3.14159265;
/// In captures a surface mirrors at most this share: light between mirrors that face each other ends.
const MOST_IN_CAPTURES: f32 = 0.9;
/// Punctual lights have no size: a highlight is never smaller than this perceptual roughness makes it.
const LEAST_HIGHLIGHT: f32 = 0.045;
/// What is left of the scene where it is the background of a view.
const DIMMED: f32 = 0.3;
/// What a light at the eye leaves of a surface that is seen edge on: floors far away are not black.
const ASKANCE: f32 = 0.25;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(5) front_direct: vec3f,
    @location(6) front_indirect: vec3f,
    @location(7) back_direct: vec3f,
    @location(8) back_indirect: vec3f,
    @location(9) @interpolate(flat) mirrored: u32,
}

#ifdef NORMAL_MAP
/// On a static surface with a normal map: the light of the side that is drawn, with its directional terms.
struct BumpedPoint {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(5) direct: vec3f,
    @location(6) direct_x: vec3f,
    @location(7) direct_y: vec3f,
    @location(8) direct_z: vec3f,
    @location(9) indirect: vec3f,
    @location(10) indirect_x: vec3f,
    @location(11) indirect_y: vec3f,
    @location(12) indirect_z: vec3f,
}

/// On a surface with a normal map that moves.
struct BumpedMovingPoint {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) tangent: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    /// Which object it is, and 1 where its transform mirrors.
    @location(5) @interpolate(flat) light: vec2u,
}
#endif

// ---- vertices

@vertex
fn still(vertex: Still) -> Point {
    var point: Point;
    point.clip = frame.clip_from_world * vec4f(vertex.position, 1.0);
    point.position = vertex.position;
    point.normal = vertex.normal;
    point.tangent = vertex.tangent;
    point.uv = vertex.uv;
    point.color = vertex.color;
    for (var k = 0u; k < 4u; k++) {
        let front = vertex.receivers[k];
        let back = vertex.back_receivers[k];
        point.front_direct += vertex.weights[k] * in_full(value_of(receivers_direct[front]));
        point.front_indirect += vertex.weights[k] * in_full(value_of(receivers_indirect[front]));
        point.back_direct += vertex.back_weights[k] * in_full(value_of(receivers_direct[back]));
        point.back_indirect += vertex.back_weights[k] * in_full(value_of(receivers_indirect[back]));
    }
    return point;
}

@vertex
fn moving(vertex: Moving) -> Point {
    let position = moved(vertex.position, vertex.row_x, vertex.row_y, vertex.row_z);
    let x = vertex.row_x.xyz;
    let y = vertex.row_y.xyz;
    let z = vertex.row_z.xyz;
    var point: Point;
    point.clip = frame.clip_from_world * vec4f(position, 1.0);
    point.position = position;
    point.normal = moved_normal(vertex.normal, x, y, z, vertex.light.y);
    point.tangent = vec4f(moved_tangent(vertex.tangent.xyz, x, y, z), vertex.tangent.w);
    point.uv = vertex.uv;
    point.color = vertex.color;
    let front = light_of_object(vertex.light.x, point.normal);
    let back = light_of_object(vertex.light.x, -point.normal);
    point.front_direct = front.direct;
    point.front_indirect = front.indirect;
    point.back_direct = back.direct;
    point.back_indirect = back.indirect;
    point.mirrored = vertex.light.y;
    return point;
}

/// Irradiance [W/m2].
struct Arriving {
    direct: vec3f,
    indirect: vec3f,
}

fn light_of_object(object: u32, normal: vec3f) -> Arriving {
    var direct: array<vec3f, 9>;
    var indirect: array<vec3f, 9>;
    for (var k = 0u; k < 9u; k++) {
        direct[k] = in_full(value_of(objects_direct[object * 9u + k]));
        indirect[k] = in_full(value_of(objects_indirect[object * 9u + k]));
    }
    return Arriving(sh::irradiance(direct, normal), sh::irradiance(indirect, normal));
}

#ifdef NORMAL_MAP
@vertex
fn still_bumped(vertex: Still) -> BumpedPoint {
    var point: BumpedPoint;
    point.clip = frame.clip_from_world * vec4f(vertex.position, 1.0);
    point.position = vertex.position;
    point.normal = vertex.normal;
    point.tangent = vertex.tangent;
    point.uv = vertex.uv;
    point.color = vertex.color;
    for (var k = 0u; k < 4u; k++) {
        let receiver = vertex.receivers[k];
        let terms = frame.directional + 3u * receiver;
        let weight = vertex.weights[k];
        point.direct += weight * in_full(value_of(receivers_direct[receiver]));
        point.direct_x += weight * in_full(value_of(receivers_direct[terms]));
        point.direct_y += weight * in_full(value_of(receivers_direct[terms + 1u]));
        point.direct_z += weight * in_full(value_of(receivers_direct[terms + 2u]));
        point.indirect += weight * in_full(value_of(receivers_indirect[receiver]));
        point.indirect_x += weight * in_full(value_of(receivers_indirect[terms]));
        point.indirect_y += weight * in_full(value_of(receivers_indirect[terms + 1u]));
        point.indirect_z += weight * in_full(value_of(receivers_indirect[terms + 2u]));
    }
    return point;
}

@vertex
fn moving_bumped(vertex: Moving) -> BumpedMovingPoint {
    let x = vertex.row_x.xyz;
    let y = vertex.row_y.xyz;
    let z = vertex.row_z.xyz;
    var point: BumpedMovingPoint;
    point.position = moved(vertex.position, vertex.row_x, vertex.row_y, vertex.row_z);
    point.clip = frame.clip_from_world * vec4f(point.position, 1.0);
    point.normal = moved_normal(vertex.normal, x, y, z, vertex.light.y);
    point.tangent = vec4f(moved_tangent(vertex.tangent.xyz, x, y, z), vertex.tangent.w);
    point.uv = vertex.uv;
    point.color = vertex.color;
    point.light = vertex.light;
    return point;
}
#endif

// ---- what is there

struct Surfel {
    position: vec3f,
    /// Of the mesh, and of the normal map on it; both on the side that is seen.
    smooth_normal: vec3f,
    normal: vec3f,
    albedo: vec3f,
    alpha: f32,
    metallic: f32,
    roughness: f32,
    /// What is reflected at normal and at grazing incidence; a dielectric's 4 % fade towards roughness 1, which is
    /// plain Lambert.
    facing: vec3f,
    edge: f32,
    /// The share of all light that is mirrored towards the viewer.
    mirrored: vec3f,
    emission: vec3f,
    to_viewer: vec3f,
    /// Irradiance [W/m2].
    direct: vec3f,
    indirect: vec3f,
}

fn surfel(point: Point, front_facing: bool) -> Surfel {
    let front = front_facing != (point.mirrored == 1u);
    let base = base_color(point.uv, point.color);
    let metals = metal(point.uv);
    var here: Surfel;
    here.position = point.position;
    here.smooth_normal = normalize(select(-point.normal, point.normal, front));
    here.normal = here.smooth_normal;
#ifdef NORMAL_MAP
    here.normal = bumped(point, here.smooth_normal, front);
#endif
    here.albedo = base.rgb;
    here.alpha = base.a;
    here.metallic = saturate(metals.x);
    here.roughness = saturate(metals.y);
    let a = here.roughness * here.roughness;
    here.facing = mix(vec3f(0.04 * (1.0 - a * a)), here.albedo, here.metallic);
    here.edge = mix(1.0 - a * a, 1.0, here.metallic);
    here.to_viewer = to_eye(point.position);
    let cosine = saturate(dot(here.normal, here.to_viewer));
    here.mirrored = reflectance(here.facing, here.edge, cosine, here.roughness);
    if frame.capture == 1u {
        here.mirrored = min(here.mirrored, vec3f(MOST_IN_CAPTURES));
    }
    here.emission = emission_at(point.uv);
    here.direct = select(point.back_direct, point.front_direct, front);
    here.indirect = select(point.back_indirect, point.front_indirect, front);
    return here;
}

#ifdef NORMAL_MAP
/// The normal map's normal in world space. Without tangents the frame comes from how position and texture
/// coordinates change over the picture (Schueler, "Normal mapping without precomputed tangents", 2006).
fn bumped(point: Point, normal: vec3f, front: bool) -> vec3f {
    let local = bump(point.uv);
    let at = mapped(material.normal_map, point.uv);
    let across = cross(dpdy(point.position), normal);
    let along = cross(normal, dpdx(point.position));
    let duv_dx = dpdx(at);
    let duv_dy = dpdy(at);
    if material.normal_map.v.w < 0.5 {
        return normal;
    }
    var tangent = across * duv_dx.x + along * duv_dy.x;
    var bitangent = -(across * duv_dx.y + along * duv_dy.y);
    let longest = max(dot(tangent, tangent), dot(bitangent, bitangent));
    if dot(point.tangent.xyz, point.tangent.xyz) > 1e-8 {
        let side = select(-1.0, 1.0, front);
        let t = point.tangent.xyz - normal * dot(normal, point.tangent.xyz);
        tangent = normalize(t);
        bitangent = cross(normal, tangent) * (point.tangent.w * side);
    } else if longest > 0.0 {
        tangent *= inverseSqrt(longest);
        bitangent *= inverseSqrt(longest);
    } else {
        return normal;
    }
    return normalize(tangent * local.x + bitangent * local.y + normal * local.z);
}
#endif

// ---- light

/// Of the light that is not mirrored, what leaves in all directions alike.
fn diffuse_albedo(here: Surfel) -> vec3f {
    let mirrored = max(here.mirrored.r, max(here.mirrored.g, here.mirrored.b));
    return here.albedo * ((1.0 - here.metallic) * (1.0 - mirrored));
}

/// Reflected by punctual lights [W/m2/sr]: spread, and as highlights.
struct Lit {
    diffuse: vec3f,
    highlights: vec3f,
}

fn lit(here: Surfel) -> Lit {
    let diffuse = diffuse_albedo(here) / PI;
    var sum = Lit(vec3f(0.0), vec3f(0.0));
#ifdef LIGHTS
    let list = lights_at(here.position);
    for (var k = 0u; k < list.count; k++) {
        let light = light_of(list, k);
        let light_here = arrival(light, here.position, 0.01);
        let cosine = dot(here.normal, light_here.towards);
        if cosine > 0.0 && dot(here.smooth_normal, light_here.towards) > 0.0
            && any(light_here.irradiance > vec3f(0.0)) {
            let share = visible_in_view(
                light, here.position, here.smooth_normal, light_here.towards, is(DOUBLE_SIDED),
            );
            let arrived = light_here.irradiance * (cosine * share);
            sum.diffuse += arrived * diffuse;
            sum.highlights += arrived * highlight(here, light_here.towards, cosine);
        }
    }
#endif
    return sum;
}

/// GGX.
fn highlight(here: Surfel, to_light: vec3f, cosine: f32) -> vec3f {
    let halfway = normalize(here.to_viewer + to_light);
    let nv = max(dot(here.normal, here.to_viewer), 1e-4);
    let nh = saturate(dot(here.normal, halfway));
    let vh = saturate(dot(here.to_viewer, halfway));
    let roughness = max(here.roughness, LEAST_HIGHLIGHT);
    let a = roughness * roughness;
    let a_squared = a * a;
    let spread = (nh * a_squared - nh) * nh + 1.0;
    let distribution = a_squared / (PI * spread * spread);
    let masking = 0.5 / (cosine * sqrt(nv * nv * (1.0 - a_squared) + a_squared)
        + nv * sqrt(cosine * cosine * (1.0 - a_squared) + a_squared));
    let fresnel = here.facing + (vec3f(here.edge) - here.facing) * pow(1.0 - vh, 5.0);
    return fresnel * (distribution * masking);
}

/// What is mirrored of all that stands around [W/m2/sr].
fn reflection(here: Surfel) -> vec3f {
    let irradiance = here.direct + here.indirect;
    let mirrored = reflect(-here.to_viewer, here.normal);
    // Where nothing is known of the surroundings, they are taken to be the same from everywhere.
    var radiance = irradiance / PI;
#ifdef CUBEMAPS
    let found = around(here.position, here.normal, here.smooth_normal, mirrored, here.roughness);
    radiance *= 1.0 - found.known;
    radiance += found.radiance * open_share(here, irradiance, found.irradiance, found.known);
#endif
    return here.mirrored * radiance * (use_of.strength * over_horizon(here, mirrored));
}

/// A place that gets less than half the light that a cubemap saw is taken to be closed in by as much: what the
/// cubemap shows is hidden from it (after Lagarde and de Rousiers 2014).
fn open_share(here: Surfel, irradiance: vec3f, seen: vec3f, known: f32) -> f32 {
    let luminance = vec3f(0.2126, 0.7152, 0.0722);
    let there = dot(seen, luminance);
    if known <= 0.0 || there <= 0.0 || use_of.baked == 0u {
        return 1.0;
    }
    let open = saturate(2.0 * dot(irradiance, luminance) * known / there);
    let cosine = saturate(dot(here.normal, here.to_viewer));
    return saturate(pow(cosine + open, exp2(-16.0 * here.roughness - 1.0)) - 1.0 + open);
}

/// A normal map can mirror what lies under the surface: that fades.
fn over_horizon(here: Surfel, mirrored: vec3f) -> f32 {
    let over = saturate(1.0 + 1.3 * dot(mirrored, here.smooth_normal));
    return over * over;
}

// ---- pictures

@fragment
fn shade(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    return picture_of(surfel(point, front));
}

#ifdef NORMAL_MAP
@fragment
fn shade_bumped(at: BumpedPoint, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let point = Point(
        at.clip, at.position, at.normal, at.tangent, at.uv, at.color,
        at.direct, at.indirect, at.direct, at.indirect, 0u,
    );
    var here = surfel(point, front);
    let direct = mat3x3f(at.direct_x, at.direct_y, at.direct_z);
    let indirect = mat3x3f(at.indirect_x, at.indirect_y, at.indirect_z);
    here.direct = tilted(here.direct, direct, here.smooth_normal, here.normal);
    here.indirect = tilted(here.indirect, indirect, here.smooth_normal, here.normal);
    return picture_of(here);
}

@fragment
fn shade_moving_bumped(at: BumpedMovingPoint, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let none = vec3f(0.0);
    let point = Point(
        at.clip, at.position, at.normal, at.tangent, at.uv, at.color,
        none, none, none, none, at.light.y,
    );
    var here = surfel(point, front);
    let light = light_of_object(at.light.x, here.normal);
    here.direct = light.direct;
    here.indirect = light.indirect;
    return picture_of(here);
}
#endif

fn picture_of(here: Surfel) -> vec4f {
#ifdef MASK
    if is(MASKED) && here.alpha < material.cutoff {
        discard;
    }
#endif
    var alpha = 1.0;
#ifdef BLEND
    alpha = select(1.0, here.alpha, is(BLENDED));
#endif
    if frame.view == ALBEDO || frame.view == NORMAL || frame.view == HEADLIGHT {
        return vec4f(plain(here), 1.0) * alpha;
    }
    let radiance = radiance_of(here, alpha);
    // Behind probes and their edges.
    let share = select(1.0, DIMMED, frame.view >= PROBES);
    return vec4f(drawn(radiance.rgb * share), radiance.a);
}

/// What views show that know no light of the scene.
fn plain(here: Surfel) -> vec3f {
    if frame.view == ALBEDO {
        return here.albedo;
    }
    if frame.view == NORMAL {
        return here.normal * 0.5 + 0.5;
    }
#ifdef UNLIT
    if is(SHINING) {
        return here.albedo;
    }
#endif
    let cosine = saturate(dot(here.normal, here.to_viewer));
    let glow = here.emission / max(1.0, max(here.emission.r, max(here.emission.g, here.emission.b)));
    return here.albedo * mix(ASKANCE, 1.0, cosine) + glow;
}

/// Radiance that is on its way to the eye, and what it covers: alpha thins out what leaves in all directions, and
/// not what is mirrored, as on glass.
fn radiance_of(here: Surfel, alpha: f32) -> vec4f {
#ifdef UNLIT
    if is(SHINING) {
        let own = select(here.albedo, vec3f(0.0), frame.view == INDIRECT || frame.view == REFLECTION);
        return vec4f(own, 1.0) * alpha;
    }
#endif
    let reflected = diffuse_albedo(here) / PI;
    let indirect = here.indirect * reflected * alpha;
    if frame.view == INDIRECT {
        return vec4f(indirect, alpha);
    }
    let mirrored = reflection(here);
    if frame.view == REFLECTION {
        return vec4f(mirrored, alpha);
    }
    let from_lights = lit(here);
    let spread = here.emission + here.direct * reflected + from_lights.diffuse;
    let direct = spread * alpha + from_lights.highlights;
    return vec4f(select(direct + indirect + mirrored, direct, frame.view == DIRECT), alpha);
}
