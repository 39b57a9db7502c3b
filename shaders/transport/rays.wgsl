// Shadow rays: whether anything stands between a point and a light. Trees are eight-wide and compressed (Ylitie,
// Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", 2017), as `obvhs`
// lays them out; the triangle test is the one of engine/src/transport/bvh.rs, its twin. What is static is one
// blocker, everything that moves another: its tree stays in its mesh's space, and the ray is taken there.
#define_import_path hohlraum::transport::rays

struct Node {
    /// Where the children's boxes are counted from.
    low: vec3f,
    /// Exponents of the boxes' units (a byte an axis), and which children are nodes (a bit each).
    units: u32,
    first_child: u32,
    first_leaf: u32,
    /// A byte a child. A node: 001, then 24 + its slot. A leaf: as many ones as triangles, then the first of them.
    /// Nothing: 0.
    kinds: vec2u,
    /// A byte a child: least of 0-3, least of 4-7, greatest of 0-3, greatest of 4-7.
    x: vec4u,
    y: vec4u,
    z: vec4u,
}

struct Triangle {
    a: vec3f,
    /// Which of the blocker's parts it belongs to: batches of the surface, primitives of a mesh.
    part: u32,
    b: vec3f,
    /// Not of this triangle: which one lies at this place of the tree's order.
    ordered: u32,
    c: vec3f,
    padding: u32,
}

struct Blocker {
    /// Of tree_from_world.
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    /// A sphere about it [m].
    centre: vec3f,
    radius: f32,
    /// Its first node, triangle and part.
    nodes: u32,
    triangles: u32,
    parts: u32,
    /// From the triangles' space to the tree's, a power of two.
    scale: f32,
}

@group(3) @binding(0) var<storage, read> nodes: array<Node>;
@group(3) @binding(1) var<storage, read> triangles: array<Triangle>;
/// The first is the static surface.
@group(3) @binding(2) var<storage, read> blockers: array<Blocker>;
/// By part of each blocker: the share of light that its triangles stop; below 0: a picture says where, and a ray that meets
/// it cannot tell.
@group(3) @binding(3) var<storage, read> stops: array<f32>;

struct Count {
    blockers: u32,
    /// How far from its surface a ray starts [m].
    offset: f32,
    padding: vec2u,
}
@group(3) @binding(4) var<uniform> count: Count;

/// Share of the light that gets from a light in the unit direction `towards`, `distance` metres off, to a point with
/// a unit normal. Nothing with holes stops it: `holes_met` says that there was such a thing.
fn let_through(position: vec3f, normal: vec3f, towards: vec3f, distance: f32) -> f32 {
    holes_met = false;
    let start = position + normal * count.offset;
    var way = towards;
    var end = distance;
    if distance < 1e30 {
        way = position + towards * distance - start;
        end = length(way);
        if end <= 4.0 * count.offset {
            return 1.0;
        }
        way /= end;
        end -= 4.0 * count.offset;
    }
    var share = 1.0;
    for (var i = 0u; i < count.blockers && share > 0.0; i++) {
        let middle = blockers[i].centre - start;
        let nearest = clamp(dot(middle, way), 0.0, end);
        let off = middle - way * nearest;
        if dot(off, off) <= blockers[i].radius * blockers[i].radius {
            share *= past(i, start, way, end);
        }
    }
    return share;
}

var<private> waiting: array<vec2u, 32>;
/// The last ray that was asked met something with holes.
var<private> holes_met: bool;

/// The share that one blocker lets through.
fn past(i: u32, start: vec3f, way: vec3f, end: f32) -> f32 {
    let blocker = blockers[i];
    let from_world = mat3x3f(blocker.row_x.xyz, blocker.row_y.xyz, blocker.row_z.xyz);
    let origin = start * from_world + vec3f(blocker.row_x.w, blocker.row_y.w, blocker.row_z.w);
    let stretched = way * from_world;
    let stretch = length(stretched);
    if !(stretch > 0.0) {
        return 1.0;
    }
    let direction = stretched / stretch;
    let last = end * stretch;
    let inverse = 1.0 / select(direction, vec3f(1.1920929e-7), abs(direction) <= vec3f(1.1920929e-7));
    let octant = dot(select(vec3u(4u, 2u, 1u), vec3u(0u), direction < vec3f(0.0)), vec3u(1u));

    var share = 1.0;
    var held = 0u;
    // Groups: the first node (leaf) and which of those that follow are to be visited, the nearest highest.
    var group = vec2u(blocker.nodes, 0x80000000u);
    var leaves = vec2u(0u);
    loop {
        while leaves.y != 0u {
            let bit = firstLeadingBit(leaves.y);
            leaves.y &= ~(1u << bit);
            let triangle = triangles[blocker.triangles + leaves.x + bit].ordered + blocker.triangles;
            let stopped = stops[blocker.parts + triangles[triangle].part];
            if stopped != 0.0 && is_met(triangle, blocker.scale, origin, direction, last) {
                holes_met = holes_met || stopped < 0.0;
                share *= 1.0 - max(stopped, 0.0);
                if share <= 0.0 {
                    return 0.0;
                }
            }
        }
        if (group.y & 0xff000000u) == 0u {
            if held == 0u {
                return share;
            }
            held -= 1u;
            group = waiting[held];
        }
        let bit = firstLeadingBit(group.y);
        let slot = (bit - 24u) ^ octant;
        let child = group.x + countOneBits(group.y & ~(0xffffffffu << slot));
        group.y &= ~(1u << bit);
        if (group.y & 0xff000000u) != 0u && held < 32u {
            waiting[held] = group;
            held += 1u;
        }
        let hits = children_met(child, origin, inverse, direction, octant, last);
        group = vec2u(blocker.nodes + nodes[child].first_child, (hits & 0xff000000u) | (nodes[child].units >> 24u));
        leaves = vec2u(nodes[child].first_leaf, hits & 0x00ffffffu);
    }
    return share;
}

/// Children whose boxes the ray meets before `last`: nodes in the highest byte, nearer ones higher; triangles below.
fn children_met(n: u32, origin: vec3f, inverse: vec3f, direction: vec3f, octant: u32, last: f32) -> u32 {
    let node = nodes[n];
    let units = bitcast<vec3f>(((vec3u(node.units) >> vec3u(0u, 8u, 16u)) & vec3u(255u)) << vec3u(23u));
    let step = units * inverse;
    let first = (node.low - origin) * inverse;
    // Entered through the greatest side where the ray goes backwards.
    let x = select(node.x, node.x.zwxy, direction.x < 0.0);
    let y = select(node.y, node.y.zwxy, direction.y < 0.0);
    let z = select(node.z, node.z.zwxy, direction.z < 0.0);
    var hits = 0u;
    for (var child = 0u; child < 8u; child++) {
        let half = child >> 2u;
        let shift = 8u * (child & 3u);
        let kind = (node.kinds[half] >> shift) & 255u;
        let low = vec3f((vec3u(x[half], y[half], z[half]) >> vec3u(shift)) & vec3u(255u)) * step + first;
        let high = vec3f((vec3u(x[half + 2u], y[half + 2u], z[half + 2u]) >> vec3u(shift)) & vec3u(255u)) * step + first;
        let enters = max(max(low.x, low.y), max(low.z, 0.0));
        let leaves = min(min(high.x, high.y), min(high.z, last));
        if enters <= leaves {
            let inner = (kind & (kind << 1u) & 16u) != 0u;
            let at = (kind ^ select(0u, octant, inner)) & 31u;
            hits |= (kind >> 5u) << at;
        }
    }
    return hits;
}

/// Between the ray's start and `last`. On which side of each edge the ray goes is told by the volume of (direction,
/// corner, corner), the same number for the two triangles that share the edge: no ray slips between them.
fn is_met(triangle: u32, scale: f32, origin: vec3f, direction: vec3f, last: f32) -> bool {
    let a = triangles[triangle].a * scale - origin;
    let b = triangles[triangle].b * scale - origin;
    let c = triangles[triangle].c * scale - origin;
    let u = dot(direction, cross(c, b));
    let v = dot(direction, cross(a, c));
    let w = dot(direction, cross(b, a));
    if min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0 {
        return false;
    }
    let volume = u + v + w;
    if volume == 0.0 {
        return false;
    }
    let t = dot(a * (u / volume) + b * (v / volume) + c * (w / volume), direction);
    return t > 0.0 && t < last;
}
