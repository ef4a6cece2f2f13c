//! For tests: walks that start anywhere on the sides of a box.

use glam::DVec3;

use super::receiver::Receiver;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::transport::{Traced, World};

/// A box with one corner at the origin, by its edges in m.
#[derive(Clone, Copy)]
pub struct EmptyBox(pub [f64; 3]);

impl EmptyBox {
    /// Area of its sides in m².
    pub fn area_m2(self) -> f64 {
        let [x, y, z] = self.0;
        2.0 * (x * y + y * z + z * x)
    }

    /// A uniformly distributed point on the sides, and the inward normal of its side.
    pub fn anywhere(self, stream: &mut Stream) -> (DVec3, DVec3) {
        let [x, y, z] = self.0;
        let mut aim = stream.unit() * self.area_m2() / 2.0;
        let axis = if aim < y * z {
            0
        } else {
            aim -= y * z;
            if aim < z * x { 1 } else { 2 }
        };
        let mut point = DVec3::new(stream.unit() * x, stream.unit() * y, stream.unit() * z);
        let mut normal = DVec3::ZERO;
        let is_low = stream.unit() < 0.5;
        point[axis] = if is_low { 0.0 } else { self.0[axis] };
        normal[axis] = if is_low { 1.0 } else { -1.0 };
        (point, normal)
    }

    /// Mean in lx, variance in lx² and rays of `count` walks that start anywhere; `walk` returns the light of one in lx and its rays.
    pub fn walks(
        self,
        world: &World,
        (count, seed): (u64, u64),
        mut walk: impl FnMut(&Receiver, &mut Cut, &mut Stream) -> Traced,
    ) -> [f64; 3] {
        let mut stream = Stream::new(seed, Purpose::Pilot, 0, 0);
        let mut cut = Cut::default();
        let (mut sum, mut squares, mut rays) = (0.0, 0.0, 0);
        for number in 0..count {
            stream.seek(number);
            let (point_m, normal) = self.anywhere(&mut stream);
            let origin = world.tracer.side_origin(point_m, normal);
            let Traced { value: lx, rays: walk_rays } =
                walk(&Receiver { point_m, normal, origin: &origin }, &mut cut, &mut stream);
            sum += lx;
            squares += lx * lx;
            rays += walk_rays;
        }
        let mean = sum / count as f64;
        [mean, squares / count as f64 - mean * mean, rays as f64 / count as f64]
    }
}
