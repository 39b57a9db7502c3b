// Lines in colours that the exposure does not change: in front of surfaces in full, behind them faintly.
#import hohlraum::frame::{frame, drawn}

const BEHIND: f32 = 0.15;

struct Point {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
}

@vertex
fn end(@location(0) position: vec3f, @location(1) color: vec4f) -> Point {
    return Point(frame.clip_from_world * vec4f(position, 1.0), color);
}

@fragment
fn in_front(point: Point) -> @location(0) vec4f {
    return vec4f(drawn(point.color.rgb / frame.exposure), point.color.a);
}

@fragment
fn behind(point: Point) -> @location(0) vec4f {
    return vec4f(drawn(point.color.rgb / frame.exposure), point.color.a * BEHIND);
}
