//! Where on the surfaces the suns of a year shine: small cells, each of which looks from a point of its own, once.
//!
//! What a walk meets takes the suns of its cell. A replica has points of its own, so that what cells cannot show differs between replicas and is in the
//! error, but for how the light's way to the receiver changes within a cell, which its size keeps small.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::base::half_samples::PARTED;
use crate::chain::{Spot, Stage};
use crate::estimators::direct::Receiver;
use crate::estimators::sunlight::Suns;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::uniform_triangle;
use crate::scene::elements::{part_at, part_corners};
use crate::scene::{Openings, Scene, Side};

/// Cells of a replica, about, at an error of 3 %, and at most: they go to where walks meet surfaces.
const CELLS: f64 = 8192.0;
const MOST_CELLS: f64 = 16_384.0;
const AT_ERROR: f64 = 0.03;
/// The least edge of a cell in m.
const LEAST_M: f64 = 0.02;
/// Steps of a share of the sun's light.
const STEPS: f64 = 65_535.0;

/// A sun by its number, and what it brings of 1 lx across its rays, in steps of 1/65535.
type SunShare = (u16, u16);

/// The suns of all cells, looked for when they are first asked for.
pub(super) struct SunCells<'a> {
    scene: &'a Scene,
    stage: &'a Stage,
    suns: &'a Suns,
    openings: Option<&'a Openings>,
    seed: u64,
    /// Parts along the edges of each side of each triangle.
    parts: Vec<u32>,
    /// First cell of each side.
    firsts: Vec<u32>,
    cells: [Vec<OnceLock<Box<[SunShare]>>>; PARTED],
    rays: AtomicU64,
}

/// Place of a side of a triangle in lists of sides.
pub(super) fn side_index((triangle, side): Spot) -> usize {
    2 * triangle as usize + side as usize
}

impl<'a> SunCells<'a> {
    /// Cells for how often walks met each side.
    pub fn new(
        (scene, stage): (&'a Scene, &'a Stage),
        suns: &'a Suns,
        openings: Option<&'a Openings>,
        meetings: &[u32],
        (target_error, seed): (f64, u64),
    ) -> SunCells<'a> {
        let cells = (CELLS * AT_ERROR / target_error).min(MOST_CELLS);
        let can_shine = |index: usize| {
            let side = if index.is_multiple_of(2) { Side::Front } else { Side::Back };
            let normal = stage.normal((index / 2) as u32, side);
            suns.towards.iter().any(|towards| normal.dot(*towards) > -suns.disk[0])
        };
        let lit: Vec<f64> = (meetings.iter().enumerate())
            .map(|(index, count)| if *count > 0 && can_shine(index) { f64::from(*count) } else { 0.0 })
            .collect();
        let all: f64 = lit.iter().sum::<f64>().max(1.0);
        let parts: Vec<u32> = lit
            .iter()
            .enumerate()
            .map(|(index, count)| {
                let [a, b, c] = scene.corners_m((index / 2) as u32);
                let longest_m = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let wanted = (cells * count / all).sqrt().ceil();
                wanted.min((longest_m / LEAST_M).ceil()).clamp(1.0, 1024.0) as u32
            })
            .collect();
        let mut firsts = Vec::with_capacity(parts.len() + 1);
        firsts.push(0);
        for count in &parts {
            firsts.push(firsts[firsts.len() - 1] + count * count);
        }
        let count = firsts[firsts.len() - 1] as usize;
        let cells = std::array::from_fn(|_| std::iter::repeat_with(OnceLock::new).take(count).collect());
        SunCells { scene, stage, suns, openings, seed, parts, firsts, cells, rays: AtomicU64::new(0) }
    }

    /// The suns that shine on a place by a replica: their numbers, and the illuminance in lx that each brings of 1 lx across its rays.
    #[inline]
    pub fn suns_on(&self, replica: usize, spot: Spot, barycentric: [f64; 2]) -> impl Iterator<Item = (usize, f64)> {
        let side = side_index(spot);
        let cell = self.firsts[side] + part_at(self.parts[side], barycentric[0], barycentric[1]);
        let shares = self.cells[replica][cell as usize].get_or_init(|| self.look(replica, spot, cell));
        shares.iter().map(|(sun, share)| (usize::from(*sun), f64::from(*share) * (1.0 / STEPS)))
    }

    /// Rays that looking took.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// Looks for all suns from a point of a cell.
    #[cold]
    fn look(&self, replica: usize, (triangle, side): Spot, cell: u32) -> Box<[SunShare]> {
        let index = side_index((triangle, side));
        let mut stream = Stream::new(self.seed, Purpose::SunPlaces, 0, replica as u32);
        stream.seek(u64::from(cell));
        let [a, b, c] = part_corners(self.parts[index], cell - self.firsts[index]);
        let [second, third] = uniform_triangle(stream.pair());
        let barycentric = [0, 1].map(|k| a[k] + second * (b[k] - a[k]) + third * (c[k] - a[k]));
        let origin = self.stage.tracer.surface_origin(triangle, barycentric, side);
        let normal: DVec3 = self.stage.normal_on(triangle, barycentric, side);
        let place = Receiver { point_m: self.stage.tracer.position_m(&origin), normal, origin: &origin };
        let mut shares = Vec::new();
        let around = (self.scene, self.stage);
        let rays = self.suns.look_for_all(around, &place, self.openings, &mut stream, |sun, lx| {
            let steps = (STEPS * lx.min(1.0)).round() as u16;
            if steps > 0 {
                shares.push((sun as u16, steps));
            }
        });
        self.rays.fetch_add(rays, Ordering::Relaxed);
        shares.into()
    }
}
