// How light is stored: three channels in four floats; or, where GREY is defined, the one that all three would be. A
// value is what is reckoned with in between: f32 or vec3f.
#define_import_path hohlraum::transport::channels

#ifdef GREY
struct Stored {
    light: f32,
}

fn dark() -> f32 {
    return 0.0;
}

fn value_of(kept: Stored) -> f32 {
    return kept.light;
}

fn stored(value: f32) -> Stored {
    return Stored(value);
}

fn largest(value: f32) -> f32 {
    return value;
}

fn in_full(value: f32) -> vec3f {
    return vec3f(value);
}

/// Of three channels that are alike.
fn of_full(full: vec3f) -> f32 {
    return full.x;
}

/// Of three channels that need not be alike, where the author does without colour: their luminance.
fn of_any(full: vec3f) -> f32 {
    return dot(full, vec3f(0.2126, 0.7152, 0.0722));
}
#else
struct Stored {
    light: vec4f,
}

fn dark() -> vec3f {
    return vec3f(0.0);
}

fn value_of(kept: Stored) -> vec3f {
    return kept.light.xyz;
}

fn stored(value: vec3f) -> Stored {
    return Stored(vec4f(value, 0.0));
}

fn largest(value: vec3f) -> f32 {
    return max(value.x, max(value.y, value.z));
}

fn in_full(value: vec3f) -> vec3f {
    return value;
}

fn of_full(full: vec3f) -> vec3f {
    return full;
}

fn of_any(full: vec3f) -> vec3f {
    return full;
}
#endif
