//! Where the picture is taken from, and what it shows.

use glam::{DAffine3, DMat3, DQuat, DVec3, Mat4, Vec3, Vec4};

use crate::scene::{AutoExposure, Camera, Projection, Scene, ToneCurve};

/// What of the light a picture shows; numbered as in `frame.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum View {
    #[default]
    Composite,
    /// Punctual lights, emission, and what comes unblocked from emitters and sky.
    Direct,
    /// All that bounced.
    Indirect,
    /// What comes from cubemaps, or stands in for it.
    Reflection,
    Albedo,
    Normal,
    /// Each patch in a colour of its own.
    Patches,
    /// Patches by size.
    Density,
    /// As a white light at the eye shows it, whatever light the scene has.
    Headlight,
    /// Light probes as spheres in their own light.
    Probes,
    /// The tetrahedra between light probes.
    Tetrahedra,
}

impl View {
    pub const ALL: [Self; 11] = [
        Self::Composite,
        Self::Direct,
        Self::Indirect,
        Self::Reflection,
        Self::Albedo,
        Self::Normal,
        Self::Patches,
        Self::Density,
        Self::Headlight,
        Self::Probes,
        Self::Tetrahedra,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Composite => "composite",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Reflection => "reflection",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Patches => "patches",
            Self::Density => "density",
            Self::Headlight => "headlight",
            Self::Probes => "probes",
            Self::Tetrahedra => "tetrahedra",
        }
    }

    /// In a circle.
    pub fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % Self::ALL.len()]
    }

    /// Shows the sky behind the scene.
    pub fn shows_sky(self) -> bool {
        matches!(self, Self::Composite | Self::Direct)
    }

    /// Shows light, which is exposed and goes through the tone curve; others show what they show.
    pub fn shows_light(self) -> bool {
        self.shows_probes()
            || matches!(self, Self::Composite | Self::Direct | Self::Indirect | Self::Reflection)
    }

    /// Shows light probes over the scene, whether anything moves or not.
    pub fn shows_probes(self) -> bool {
        matches!(self, Self::Probes | Self::Tetrahedra)
    }

    /// Shows patches instead of surfaces.
    pub fn shows_patches(self) -> bool {
        matches!(self, Self::Patches | Self::Density)
    }
}

/// Metres from the origin, and of near planes and pictures without perspective: their squares are floats.
const FARTHEST: f32 = 1e15;

/// A camera at its place in the world. Looks along its -Z, +Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    pub position: DVec3,
    pub rotation: DQuat,
    pub projection: Projection,
    /// Metres.
    pub near: f32,
    pub far: Option<f32>,
    /// Display = 2^exposure * radiance.
    pub exposure: f32,
    /// Instead of `exposure`.
    pub auto_exposure: Option<AutoExposure>,
    pub tonemap: ToneCurve,
}

impl Eye {
    pub fn of_camera(camera: &Camera, world_from_local: &DAffine3) -> Self {
        let m = world_from_local.matrix3;
        let back = m.z_axis.normalize_or(DVec3::Z);
        let right = m.y_axis.cross(back).normalize_or(back.any_orthonormal_vector());
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        Self {
            position: world_from_local.translation,
            rotation,
            projection: camera.projection,
            near: camera.near,
            far: camera.far,
            exposure: camera.exposure,
            auto_exposure: camera.auto_exposure,
            tonemap: camera.tonemap,
        }
    }

    /// Looks from `position` at `at`.
    pub fn looking(position: DVec3, at: DVec3) -> Self {
        let back = (position - at).normalize_or(DVec3::Z);
        let right = DVec3::Y.cross(back).normalize_or(DVec3::X);
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        let world_from_local = DAffine3::from_rotation_translation(rotation, position);
        Self::of_camera(&Camera::default(), &world_from_local)
    }

    /// With so many stops, whatever the camera says.
    pub fn exposed(mut self, stops: Option<f32>) -> Self {
        if let Some(stops) = stops {
            (self.exposure, self.auto_exposure) = (stops, None);
        }
        self
    }

    /// The scene's camera, if it has one.
    pub fn of_scene(scene: &Scene, world_from_local: &[DAffine3]) -> Option<Self> {
        let mut placed = scene.entities.iter().zip(world_from_local);
        placed.find_map(|(entity, world)| Some(Self::of_camera(entity.camera.as_ref()?, world)))
    }

    /// From in front of a box and above it, so that all of it is in the picture.
    pub fn framing(low: DVec3, high: DVec3) -> Self {
        let (centre, radius) = ((low + high) * 0.5, ((high - low).length() * 0.5).max(0.5));
        let way = DVec3::new(0.35, 0.45, 1.0).normalize();
        let mut eye = Self::looking(centre + way * radius * 2.6, centre);
        eye.near = (radius * 0.01) as f32;
        eye
    }

    /// Half width and half height of the picture at distance 1 (parallel rays: in metres).
    pub fn half(&self, aspect: f32) -> [f32; 2] {
        let height = match self.projection {
            Projection::Perspective { fov_y } => (fov_y.clamp(1e-3, 3.1) * 0.5).tan(),
            Projection::Orthographic { half_height } => half_height.abs().clamp(1e-6, FARTHEST),
        };
        [height * aspect, height]
    }

    /// `clip_from_world`, with world positions relative to `origin`. Depth is reversed: 1 near, 0 far.
    pub fn clip_from_world(&self, origin: DVec3, aspect: f32) -> Mat4 {
        let [x, y] = self.half(aspect);
        let near = self.near.clamp(1e-6, FARTHEST);
        let far = self.far.filter(|far| far.is_finite() && *far > near);
        let clip_from_view = match self.projection {
            Projection::Perspective { .. } => perspective(x, y, near, far),
            Projection::Orthographic { .. } => orthographic(x, y, near, far.unwrap_or(near + near.max(1e4))),
        };
        clip_from_view * view_from_world(self.place(origin), self.axes())
    }

    /// Where it is, relative to `origin`; what is farther away than can be told is at the farthest.
    fn place(&self, origin: DVec3) -> Vec3 {
        let most = DVec3::splat(f64::from(FARTHEST));
        let place = self.position - origin;
        if place.is_nan() { Vec3::ZERO } else { place.clamp(-most, most).as_vec3() }
    }

    /// Right, up, back.
    pub fn axes(&self) -> [Vec3; 3] {
        [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (self.rotation * axis).as_vec3())
    }

    /// For `frame.wgsl`: the eye (or the direction of parallel rays), and the ways to the middle and the edges.
    pub fn rays(&self, origin: DVec3, aspect: f32) -> (Vec4, [Vec3; 3]) {
        let [right, up, back] = self.axes();
        let [x, y] = self.half(aspect);
        match self.projection {
            Projection::Perspective { .. } => (self.place(origin).extend(1.0), [-back, right * x, up * y]),
            Projection::Orthographic { .. } => (back.extend(0.0), [-back, Vec3::ZERO, Vec3::ZERO]),
        }
    }
}

pub fn view_from_world(position: Vec3, [right, up, back]: [Vec3; 3]) -> Mat4 {
    let at = -Vec3::new(right.dot(position), up.dot(position), back.dot(position));
    Mat4::from_cols(
        Vec4::new(right.x, up.x, back.x, 0.0),
        Vec4::new(right.y, up.y, back.y, 0.0),
        Vec4::new(right.z, up.z, back.z, 0.0),
        at.extend(1.0),
    )
}

/// Half width `x` and half height `y` at distance 1; depth 1 at `near`, 0 at `far` or at infinity.
pub fn perspective(x: f32, y: f32, near: f32, far: Option<f32>) -> Mat4 {
    let (scale, offset) = match far {
        Some(far) => (near / (far - near), near / (far - near) * far),
        None => (0.0, near),
    };
    Mat4::from_cols(
        Vec4::new(1.0 / x, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.0 / y, 0.0, 0.0),
        Vec4::new(0.0, 0.0, scale, -1.0),
        Vec4::new(0.0, 0.0, offset, 0.0),
    )
}

/// The box of half width `x`, half height `y`, between `near` (depth 1) and `far` (depth 0).
pub fn orthographic(x: f32, y: f32, near: f32, far: f32) -> Mat4 {
    let depth = far - near;
    Mat4::from_cols(
        Vec4::new(1.0 / x, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 1.0 / y, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0 / depth, 0.0),
        Vec4::new(0.0, 0.0, far / depth, 1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_reversed() {
        let seen = |m: Mat4, z: f32| m.project_point3(Vec3::new(0.0, 0.0, -z)).z;
        for (matrix, far) in [
            (perspective(1.0, 1.0, 0.1, None), f32::INFINITY),
            (perspective(1.0, 1.0, 0.1, Some(50.0)), 50.0),
            (orthographic(1.0, 1.0, 0.1, 50.0), 50.0),
        ] {
            assert!((seen(matrix, 0.1) - 1.0).abs() < 1e-6);
            assert!(seen(matrix, far.min(1e9)).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_looked_at_is_in_the_middle() {
        let origin = DVec3::new(1e6, 0.0, 0.0);
        let eye = Eye::looking(origin + DVec3::new(3.0, 2.0, 1.0), origin);
        let clip = eye.clip_from_world(origin, 1.5);
        assert!(clip.project_point3(Vec3::ZERO).truncate().length() < 1e-6);
        let right = clip.project_point3(eye.axes()[0]);
        assert!(right.x > 0.0 && right.y.abs() < 1e-6);
    }
}
