//! Cells: surface points that share one value of illuminance for rays that come from far enough away.
//!
//! A cell is a cube of a world-aligned grid whose edge is a power of two in metres. It also has one of several directions of surface
//! normals and the octant of the ray that looks it up. The edge follows from the length of that ray, so a cell fills about the same solid
//! angle for every ray. Nothing is meshed beforehand, so twelve triangles and ten million take the same effort. The octant separates the
//! two sides of a thin wall; closed rooms have cells of their own.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::base::memory::bytes_of_list;

/// Parts of either axis of the octahedral map of normals. The number is odd, so that normals along an axis lie within a part.
const NORMAL_PARTS: f64 = 7.0;
/// Exponent of two of the finest edge over the scene's longest distance.
const FINEST: i32 = -13;
/// Initial number of slots of a table.
const FIRST_SLOTS: usize = 1 << 10;
/// Marks a free slot of the table.
const FREE: u32 = u32::MAX;

/// A surface point whose cell a ray looks up.
#[derive(Clone, Copy, Debug)]
pub struct Lookup {
    /// Point in m.
    pub point_m: DVec3,
    /// Unit normal of the lit side.
    pub normal: DVec3,
    /// Unit direction of the ray.
    pub direction: DVec3,
    /// Length of the ray in m, or a multiple of it for a cell of a larger edge.
    pub distance_m: f64,
    /// Number of the room in which the point lies. Rooms share no cells.
    pub room: u8,
}

/// Position of a cell: enough to distinguish it from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellKey {
    /// Cube numbers along the axes.
    cube: [i32; 3],
    /// Level of its edge, room, part of its normal and octant of the rays that look it up.
    kind: u32,
}

impl CellKey {
    /// 64-bit hash of the key. Among ten million cells, the chance that any two have the same hash is 3 in a million.
    fn fingerprint(&self) -> u64 {
        let [x, y, z] = [self.cube[0] as u32, self.cube[1] as u32, self.cube[2] as u32];
        // Each number is mixed before the next joins it. Otherwise low bits of the kind and of the cube would cancel, and a cell would
        // equal its neighbour for rays from the other side.
        let mut bits = 0;
        for number in [self.kind, x, y, z] {
            bits = (bits ^ u64::from(number)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            bits ^= bits >> 29;
        }
        bits = bits.wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits ^ (bits >> 32)
    }

    /// How many times its edge is doubled from the finest edge.
    pub fn level(&self) -> u32 {
        self.kind >> LEVEL_BIT
    }
}

/// First bit of the room in a key's kind, and of the level.
const ROOM_BIT: u32 = 9;
const LEVEL_BIT: u32 = 17;

/// The cells that were looked up, in the order of their first look-up.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "GridKeys")]
pub struct CellGrid {
    /// Corner from which cubes are counted, in m.
    origin_m: DVec3,
    /// Edge of a cell over the length of the ray that looks it up, at most.
    edge_share: f64,
    /// Exponent of two of the finest edge in m.
    finest: i32,
    /// Exponent of two of the coarsest edge over the finest.
    coarsest: i32,
    keys: Vec<CellKey>,
    /// Slots with open addressing. Their number is a power of two. They follow from the keys.
    #[serde(skip)]
    table: Vec<CellSlot>,
}

/// The part of the cells that is written to a file and read again.
#[derive(Deserialize)]
struct GridKeys {
    origin_m: DVec3,
    edge_share: f64,
    finest: i32,
    coarsest: i32,
    keys: Vec<CellKey>,
}

impl From<GridKeys> for CellGrid {
    fn from(GridKeys { origin_m, edge_share, finest, coarsest, keys }: GridKeys) -> CellGrid {
        let table = Vec::new();
        let mut grid = CellGrid { origin_m, edge_share, finest, coarsest, keys, table };
        grid.make_table((2 * grid.keys.len()).next_power_of_two().max(FIRST_SLOTS));
        grid
    }
}

/// A slot of the table: everything that a look-up reads lies in one cache line.
#[derive(Clone, Copy, Debug)]
struct CellSlot {
    fingerprint: u64,
    cell: u32,
}

impl CellSlot {
    const FREE: CellSlot = CellSlot { fingerprint: 0, cell: FREE };
}

impl CellGrid {
    /// An empty grid for a scene between two corners, in m. It is shifted by `shift`, in shares of half the scene's longest distance. The
    /// edge of a cell is at most `edge_share` times the length of the ray that looks it up, and more than half of that.
    ///
    /// Each half has its own shift. The positions of cells are then random, and the difference of the halves shows their effect.
    pub fn new([least_m, most_m]: [DVec3; 2], shift: [f64; 3], edge_share: f64) -> CellGrid {
        let longest_m = (most_m - least_m).length().max(f64::MIN_POSITIVE);
        let finest = longest_m.log2().ceil() as i32 + FINEST;
        CellGrid {
            origin_m: least_m - longest_m * (0.01 + 0.5 * DVec3::from(shift)),
            edge_share,
            finest,
            coarsest: -FINEST,
            keys: Vec::new(),
            table: vec![CellSlot::FREE; FIRST_SLOTS],
        }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether no cell was looked up yet.
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Memory of the cells in bytes.
    pub fn bytes(&self) -> usize {
        bytes_of_list(&self.keys) + bytes_of_list(&self.table)
    }

    /// The cell of a surface point. Creates it at its first look-up.
    #[inline]
    pub fn look_up(&mut self, lookup: &Lookup) -> u32 {
        let key = self.key(lookup);
        self.cell(key)
    }

    /// The same grid without cells.
    pub fn emptied(&self) -> CellGrid {
        CellGrid { keys: Vec::new(), table: vec![CellSlot::FREE; FIRST_SLOTS], ..*self }
    }

    /// Position of a cell.
    pub fn key_of(&self, cell: u32) -> CellKey {
        self.keys[cell as usize]
    }

    /// Position of the cell of twice the edge that contains this one. `None` at the top.
    #[inline]
    pub fn above(&self, key: CellKey) -> Option<CellKey> {
        let at_top = key.level() as i32 >= self.coarsest;
        let [x, y, z] = key.cube;
        (!at_top).then(|| CellKey { cube: [x >> 1, y >> 1, z >> 1], kind: key.kind + (1 << LEVEL_BIT) })
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.coarsest as usize + 1
    }

    /// Position of the cell of a surface point.
    #[inline]
    pub fn key(&self, lookup: &Lookup) -> CellKey {
        let edge_m = self.edge_share * lookup.distance_m;
        // The exponent of a float is the power of two at or below it.
        let power = ((edge_m.to_bits() >> 52) & 0x7FF) as i32 - 1023;
        let level = (power - self.finest).clamp(0, self.coarsest);
        let per_m = f64::from_bits(((1023 - self.finest - level) as u64) << 52);
        let cube = (lookup.point_m - self.origin_m) * per_m;
        let octant = u32::from(lookup.direction.x > 0.0)
            | u32::from(lookup.direction.y > 0.0) << 1
            | u32::from(lookup.direction.z > 0.0) << 2;
        let place = u32::from(lookup.room) << ROOM_BIT | part_of_normal(lookup.normal) << 3;
        let kind = (level as u32) << LEVEL_BIT | place | octant;
        CellKey { cube: [cube.x as i32, cube.y as i32, cube.z as i32], kind }
    }

    /// The cell at a position, if it has been looked up before.
    #[inline]
    pub fn find(&self, key: CellKey) -> Option<u32> {
        let cell = self.table[self.slot(key.fingerprint())].cell;
        (cell != FREE).then_some(cell)
    }

    /// The cell at a position. Creates it at its first look-up.
    #[inline]
    pub fn cell(&mut self, key: CellKey) -> u32 {
        let fingerprint = key.fingerprint();
        let slot = self.slot(fingerprint);
        if self.table[slot].cell != FREE {
            return self.table[slot].cell;
        }
        let cell = self.keys.len() as u32;
        self.keys.push(key);
        self.table[slot] = CellSlot { fingerprint, cell };
        if 2 * self.keys.len() > self.table.len() {
            self.make_table(2 * self.table.len());
        }
        cell
    }

    /// The slot that holds a key, or the free one where it belongs.
    #[inline]
    fn slot(&self, fingerprint: u64) -> usize {
        let mask = self.table.len() - 1;
        let mut slot = fingerprint as usize & mask;
        while self.table[slot].cell != FREE && self.table[slot].fingerprint != fingerprint {
            slot = (slot + 1) & mask;
        }
        slot
    }

    /// Makes a table of `slots` slots, a power of two, that holds all keys.
    fn make_table(&mut self, slots: usize) {
        self.table = vec![CellSlot::FREE; slots];
        for cell in 0..self.keys.len() {
            let fingerprint = self.keys[cell].fingerprint();
            let slot = self.slot(fingerprint);
            self.table[slot] = CellSlot { fingerprint, cell: cell as u32 };
        }
    }
}

/// Part of the octahedral map that contains a unit normal.
#[inline]
fn part_of_normal(normal: DVec3) -> u32 {
    let scale = 1.0 / (normal.x.abs() + normal.y.abs() + normal.z.abs());
    let (mut u, mut v) = (normal.x * scale, normal.y * scale);
    if normal.z < 0.0 {
        (u, v) = ((1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v));
    }
    let part = |share: f64| ((0.5 + 0.499_999 * share) * NORMAL_PARTS) as u32;
    part(u) | part(v) << 4
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lookup(point_m: DVec3, normal: DVec3, distance_m: f64) -> Lookup {
        Lookup { point_m, normal, direction: -normal, distance_m, room: 0 }
    }

    #[test]
    fn cells_grow_with_the_length_of_the_ray_and_hold_their_children() {
        let mut grid = CellGrid::new([DVec3::ZERO, DVec3::splat(4.0)], [0.2, 0.3, 0.4], 0.25);
        let near = grid.look_up(&lookup(DVec3::new(1.0, 2.0, 0.0), DVec3::Z, 0.5));
        let far = grid.look_up(&lookup(DVec3::new(1.0, 2.0, 0.0), DVec3::Z, 4.0));
        let [near, far] = [near, far].map(|cell| grid.key_of(cell));
        assert_eq!(far.level(), near.level() + 3);
        let above = (0..3).fold(near, |key, _| grid.above(key).expect("not at the top"));
        assert_eq!(above, far);
    }

    #[test]
    fn sides_of_a_thin_wall_have_cells_of_their_own() {
        let mut grid = CellGrid::new([DVec3::ZERO, DVec3::splat(4.0)], [0.2, 0.3, 0.4], 0.25);
        let [one, other] = [1e-6, -1e-6].map(|x| {
            let (point_m, normal) = (DVec3::new(2.0 + x, 1.0, 0.0), DVec3::Z);
            let direction = DVec3::new(-x.signum(), 0.1, -1.0).normalize();
            grid.look_up(&Lookup { point_m, normal, direction, distance_m: 2.0, room: 0 })
        });
        assert_ne!(one, other);
    }

    #[test]
    fn rooms_share_no_cells() {
        let mut grid = CellGrid::new([DVec3::ZERO, DVec3::splat(4.0)], [0.2, 0.3, 0.4], 0.25);
        let [one, other] = [0, 255].map(|room| {
            let cell = grid.look_up(&Lookup { room, ..lookup(DVec3::ONE, DVec3::Z, 1.0) });
            grid.key_of(cell)
        });
        let above = [one, other].map(|key| grid.above(key).expect("not at the top"));
        assert!(one != other && above[0] != above[1] && one.level() == other.level());
    }

    /// Cells of 16³ cubes, eight octants, three normals and three levels, 294,912 in all: no two have the same fingerprint. If the cube
    /// numbers are combined with the bits of the kind unmixed (the planted fault), most have.
    #[test]
    fn cells_that_differ_in_place_octant_normal_or_level_are_distinguished() {
        let mut keys = Vec::new();
        for place in 0..16 * 16 * 16 {
            for kind in 0..8 * 3 * 3 {
                let normal = part_of_normal([DVec3::X, DVec3::Y, DVec3::NEG_Z][kind / 8 % 3]);
                let kind = (kind as u32 / 24) << LEVEL_BIT | normal << 3 | (kind as u32 % 8);
                keys.push(CellKey { cube: [place / 256, place / 16 % 16, place % 16], kind });
            }
        }
        let distinct = |fingerprint: &dyn Fn(&CellKey) -> u64| {
            keys.iter().map(fingerprint).collect::<std::collections::HashSet<u64>>().len()
        };
        assert_eq!(distinct(&CellKey::fingerprint), keys.len());
        let faulty = |key: &CellKey| {
            let first = (u64::from(key.kind) ^ key.cube[0] as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            first ^ (key.cube[1] as u64) << 20 ^ (key.cube[2] as u64) << 40
        };
        assert!(distinct(&faulty) < keys.len() / 4);
    }

    #[test]
    fn all_cells_are_found_again_as_the_table_grows() {
        let mut grid = CellGrid::new([DVec3::ZERO, DVec3::splat(4.0)], [0.2, 0.3, 0.4], 0.25);
        let place =
            |index: usize| lookup(DVec3::new((index % 60) as f64, (index / 60) as f64, 0.0) / 15.0, DVec3::Z, 0.1);
        let found: Vec<u32> = (0..3600).map(|index| grid.look_up(&place(index))).collect();
        assert!(grid.len() > 3000);
        assert!((0..3600).all(|index| grid.look_up(&place(index)) == found[index]));
    }
}
