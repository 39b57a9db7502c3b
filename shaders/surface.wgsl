// Surfaces: direct light from punctual lights with shadows, and what receivers (or light probes, for what
// moves) say of the rest. Lambert for diffuse light, so that pictures agree with the transport to the last
// digit; GGX (Walter et al. 2007, height-correlated Smith by Heitz 2014) with Schlick's Fresnel on top.
#import hohlraum::frame::{frame, to_eye, COMPOSITE, DIRECT, INDIRECT, ALBEDO}
#import hohlraum::scene::mesh::{Still, Moving, moved, moved_normal, moved_tangent}
#import hohlraum::scene::material::{material, base_color, metal, emission_at, bump, is, mapped, MASK, BLEND, UNLIT, DOUBLE_SIDED}
#import hohlraum::scene::light::{lights_at, light_of, arrival, visible_in_view}
#import hohlraum::transport::sh

/// Irradiance at receivers [W/m2]: seen unblocked from emitters and sky, and all that bounced.
@group(2) @binding(0) var<storage, read> receivers_direct: array<vec4f>;
@group(2) @binding(1) var<storage, read> receivers_indirect: array<vec4f>;
/// Nine coefficients a light probe, likewise.
@group(2) @binding(2) var<storage, read> probes_direct: array<vec4f>;
@group(2) @binding(3) var<storage, read> probes_indirect: array<vec4f>;

const PI: f32 = 3.14159265;

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
        point.front_direct += vertex.weights[k] * receivers_direct[front].xyz;
        point.front_indirect += vertex.weights[k] * receivers_indirect[front].xyz;
        point.back_direct += vertex.back_weights[k] * receivers_direct[back].xyz;
        point.back_indirect += vertex.back_weights[k] * receivers_indirect[back].xyz;
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
    var direct: array<vec3f, 9>;
    var indirect: array<vec3f, 9>;
    for (var k = 0u; k < 9u; k++) {
        direct[k] = probes_direct[vertex.light.x * 9u + k].xyz;
        indirect[k] = probes_indirect[vertex.light.x * 9u + k].xyz;
    }
    point.front_direct = sh::irradiance(direct, point.normal);
    point.front_indirect = sh::irradiance(indirect, point.normal);
    point.back_direct = sh::irradiance(direct, -point.normal);
    point.back_indirect = sh::irradiance(indirect, -point.normal);
    point.mirrored = vertex.light.y;
    return point;
}

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
    emission: vec3f,
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
    here.normal = bumped(point, here.smooth_normal, front);
    here.albedo = base.rgb;
    here.alpha = base.a;
    here.metallic = saturate(metals.x);
    here.roughness = clamp(metals.y, 0.045, 1.0);
    here.emission = emission_at(point.uv);
    here.direct = select(point.back_direct, point.front_direct, front);
    here.indirect = select(point.back_indirect, point.front_indirect, front);
    return here;
}

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

// ---- light

/// Reflected by punctual lights [W/m2/sr].
fn lit(here: Surfel) -> vec3f {
    let to_viewer = to_eye(here.position);
    let diffuse = here.albedo * ((1.0 - here.metallic) / PI);
    var sum = vec3f(0.0);
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
            let reflected = diffuse + specular(here, to_viewer, light_here.towards, cosine);
            sum += light_here.irradiance * reflected * (cosine * share);
        }
    }
    return sum;
}

/// GGX. A dielectric's 4 % fade towards roughness 1, which is plain Lambert.
fn specular(here: Surfel, to_viewer: vec3f, to_light: vec3f, cosine: f32) -> vec3f {
    let halfway = normalize(to_viewer + to_light);
    let nv = max(dot(here.normal, to_viewer), 1e-4);
    let nh = saturate(dot(here.normal, halfway));
    let vh = saturate(dot(to_viewer, halfway));
    let a = here.roughness * here.roughness;
    let a_squared = a * a;
    let spread = (nh * a_squared - nh) * nh + 1.0;
    let distribution = a_squared / (PI * spread * spread);
    let masking = 0.5 / (cosine * sqrt(nv * nv * (1.0 - a_squared) + a_squared)
        + nv * sqrt(cosine * cosine * (1.0 - a_squared) + a_squared));
    let facing = mix(vec3f(0.04 * (1.0 - a_squared)), here.albedo, here.metallic);
    let edge = mix(1.0 - a_squared, 1.0, here.metallic);
    let fresnel = facing + (vec3f(edge) - facing) * pow(1.0 - vh, 5.0);
    return fresnel * (distribution * masking);
}

// ---- pictures

@fragment
fn shade(point: Point, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let here = surfel(point, front);
    if is(MASK) && here.alpha < material.cutoff {
        discard;
    }
    return vec4f(seen(here), select(1.0, here.alpha, is(BLEND)));
}

fn seen(here: Surfel) -> vec3f {
    if frame.view == ALBEDO {
        return here.albedo;
    }
    if frame.view > ALBEDO {
        return here.normal * 0.5 + 0.5;
    }
    if is(UNLIT) {
        return select(here.albedo, vec3f(0.0), frame.view == INDIRECT);
    }
    // A metal's reflection of its surroundings is, until captures are there, its colour times the mean.
    let reflected = here.albedo / PI;
    let indirect = here.indirect * reflected;
    if frame.view == INDIRECT {
        return indirect;
    }
    let direct = here.emission + here.direct * reflected + lit(here);
    return select(direct + indirect, direct, frame.view == DIRECT);
}
