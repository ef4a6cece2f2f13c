//! Cells: surface points that share one value of illuminance for rays that come from far enough away.
//!
//! A cell is a part of a cube of a world-aligned grid whose edge is a power of two in metres, for surface normals of about one direction.
//! The edge follows from the length of the ray that looks the cell up, so a cell fills about the same solid angle for every ray. Nothing is
//! meshed beforehand, so twelve triangles and ten million take the same effort. Where a wall crosses a cube, the points on its two sides
//! have different cells: see [`CellGrid::key`].

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::base::memory::bytes_of_list;

/// Parts of either axis of the octahedral map of normals. The number is odd, so that normals along an axis lie within a part.
const NORMAL_PARTS: f64 = 7.0;
/// Depths of the middle of a cube behind a surface that are told apart, per edge; and the most of them.
const DEPTHS_AN_EDGE: f64 = 4.0;
const MOST_DEPTHS: f64 = 3.0;
/// Part of points from which the middle of even the smallest cube is hidden.
const HIDDEN: u32 = 2 + MOST_DEPTHS as u32;
/// How often a cube is halved, at most, for a point from which its middle is hidden.
const MOST_HALVINGS: i32 = 5;
/// Least height over a surface of the point that stands for the middle of a cube, over the cube's edge.
const LEAST_HEIGHT: f64 = 1.0 / 32.0;
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
    /// Length of the ray in m, or a multiple of it for a cell of a larger edge.
    pub distance_m: f64,
}

/// Position of a cell: enough to distinguish it from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellKey {
    /// Cube numbers along the axes.
    cube: [i32; 3],
    /// Level of its edge, enclosure, part of the cube and part of the normals.
    kind: u32,
}

impl CellKey {
    /// 64-bit hash of the key. Among ten million cells, the chance that any two have the same hash is 3 in a million.
    fn fingerprint(&self) -> u64 {
        let [x, y, z] = [self.cube[0] as u32, self.cube[1] as u32, self.cube[2] as u32];
        // Each number is mixed before the next joins it. Otherwise low bits of the kind and of the cube would cancel, and a cell would
        // equal another part of its neighbour.
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

    /// The same cell for the light of one enclosure alone. Looked-up cells are in enclosure 0.
    pub fn within(self, enclosure: u8) -> CellKey {
        CellKey { kind: self.kind | u32::from(enclosure) << ENCLOSURE_BIT, ..self }
    }
}

/// First bits of the part, of the enclosure and of the level in a key's kind. The part of the normals comes before them.
const PART_BIT: u32 = 6;
const ENCLOSURE_BIT: u32 = 9;
const LEVEL_BIT: u32 = 17;

/// The cells that were looked up, in the order of their first look-up.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "GridKeys")]
pub struct CellGrid {
    /// Corners of the scene, and the corner from which cubes are counted, in m.
    bounds_m: [DVec3; 2],
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
    bounds_m: [DVec3; 2],
    origin_m: DVec3,
    edge_share: f64,
    finest: i32,
    coarsest: i32,
    keys: Vec<CellKey>,
}

impl From<GridKeys> for CellGrid {
    fn from(GridKeys { bounds_m, origin_m, edge_share, finest, coarsest, keys }: GridKeys) -> CellGrid {
        let table = Vec::new();
        let mut grid = CellGrid { bounds_m, origin_m, edge_share, finest, coarsest, keys, table };
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
            bounds_m: [least_m, most_m],
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

    /// Position of the cell of a surface point. `sees` tells whether nothing lies between the point and another one in m.
    ///
    /// All points of a cell see the middle of its cube, so no wall separates them. A point from which something hides the middle takes a
    /// smaller cube. Where the middle lies behind the point's surface, the point right above the surface stands for it, and planes at
    /// different depths have different cells: shelves one above another.
    #[inline]
    pub fn key(&self, lookup: &Lookup, sees: impl Fn(DVec3) -> bool) -> CellKey {
        let edge_m = self.edge_share * lookup.distance_m;
        // The exponent of a float is the power of two at or below it.
        let power = ((edge_m.to_bits() >> 52) & 0x7FF) as i32 - 1023;
        let level = (power - self.finest).clamp(0, self.coarsest);
        let least = (level - MOST_HALVINGS).max(0);
        let mut level = level;
        loop {
            let edge_m = f64::from_bits(((1023 + self.finest + level) as u64) << 52);
            let cube = ((lookup.point_m - self.origin_m) / edge_m).floor();
            let (middle_m, part) = self.middle(lookup, cube, edge_m);
            let seen = sees(middle_m);
            if seen || level == least {
                let part = if seen { part } else { HIDDEN };
                let kind = (level as u32) << LEVEL_BIT | part << PART_BIT | part_of_normal(lookup.normal);
                return CellKey { cube: cube.as_ivec3().to_array(), kind };
            }
            level -= 1;
        }
    }

    /// The point that stands for the middle of a cube for a surface point, in m, and the part of the cube in which the surface point lies. A
    /// middle outside the scene is moved into it, since walls would hide it from all points.
    #[inline]
    fn middle(&self, lookup: &Lookup, cube: DVec3, edge_m: f64) -> (DVec3, u32) {
        let least_m = LEAST_HEIGHT * edge_m;
        let [low_m, high_m] = self.bounds_m;
        let inset_m = (0.5 * (high_m - low_m)).min(DVec3::splat(least_m));
        let middle_m = (self.origin_m + (cube + 0.5) * edge_m).clamp(low_m + inset_m, high_m - inset_m);
        let height_m = (middle_m - lookup.point_m).dot(lookup.normal);
        if height_m >= least_m {
            return (middle_m, 0);
        }
        let depth = (DEPTHS_AN_EDGE * -height_m / edge_m).clamp(0.0, MOST_DEPTHS);
        (middle_m + (least_m - height_m) * lookup.normal, 1 + depth as u32)
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
    part(u) | part(v) << 3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lookup(point_m: DVec3, normal: DVec3, distance_m: f64) -> Lookup {
        Lookup { point_m, normal, distance_m }
    }

    fn grid() -> CellGrid {
        CellGrid::new([DVec3::ZERO, DVec3::splat(4.0)], [0.2, 0.3, 0.4], 0.25)
    }

    #[test]
    fn cells_grow_with_the_length_of_the_ray_and_hold_their_children() {
        let grid = grid();
        let [near, far] =
            [0.5, 4.0].map(|distance_m| grid.key(&lookup(DVec3::new(1.0, 2.0, 0.0), DVec3::Z, distance_m), |_| true));
        assert_eq!(far.level(), near.level() + 3);
        let above = (0..3).fold(near, |key, _| grid.above(key).expect("not at the top"));
        assert_eq!(above.cube, far.cube);
    }

    /// A wall crosses cubes on the floor: at any place in a cube, even where it hides the middle from both sides.
    #[test]
    fn the_two_sides_of_a_wall_have_different_cells() {
        let grid = grid();
        for wall_m in (0..400).map(|step| 1.0 + 0.005 * f64::from(step)) {
            let [one, other] = [-0.03, 0.03].map(|x| {
                let point_m = DVec3::new(wall_m + x, 1.0, 0.0);
                let sees = |to_m: DVec3| (to_m.x - wall_m) * x > 0.0 && (to_m.x - wall_m).abs() > 0.02;
                grid.key(&lookup(point_m, DVec3::Z, 2.0), sees)
            });
            assert_ne!(one, other, "{wall_m}");
        }
    }

    /// Boards that hide one another, three tenths of an edge or more apart.
    #[test]
    fn boards_one_above_another_have_different_cells() {
        let grid = grid();
        for low_m in (0..100).map(|step| 1.0 + 0.01 * f64::from(step)) {
            for gap_m in [0.15, 0.2, 0.4] {
                let [low, high] = [low_m, low_m + gap_m].map(|board_m| {
                    let sees = |to_m: DVec3| to_m.z > board_m && (board_m > low_m || to_m.z < low_m + gap_m);
                    grid.key(&lookup(DVec3::new(1.0, 2.0, board_m), DVec3::Z, 2.0), sees)
                });
                assert_ne!(low, high, "{low_m} {gap_m}");
            }
        }
    }

    /// Normals, parts, enclosures and levels have bits of their own in a key.
    #[test]
    fn nothing_in_a_key_overlaps() {
        let grid = grid();
        let mut found = std::collections::HashSet::new();
        let normals = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        for normal in normals {
            for sees in [true, false] {
                let key = grid.key(&lookup(DVec3::ONE, normal, 1.0), |_| sees);
                (0..=255)
                    .for_each(|enclosure| assert!(found.insert(key.within(enclosure).kind), "{key:?} {enclosure}"));
                let above = grid.above(key.within(255)).expect("not at the top");
                assert!(found.insert(above.kind) && above.level() == key.level() + 1);
            }
        }
    }

    /// Cells of 16³ cubes, eight parts, three normals and three levels, 294,912 in all: no two have the same fingerprint. If the cube
    /// numbers are combined with the bits of the kind unmixed (the planted fault), most have.
    #[test]
    fn cells_that_differ_in_place_part_normal_or_level_are_distinguished() {
        let mut keys = Vec::new();
        for place in 0..16 * 16 * 16 {
            for kind in 0..8 * 3 * 3 {
                let normal = part_of_normal([DVec3::X, DVec3::Y, DVec3::NEG_Z][kind / 8 % 3]);
                let kind = (kind as u32 / 24) << LEVEL_BIT | (kind as u32 % 8) << PART_BIT | normal;
                keys.push(CellKey { cube: [place / 256, place / 16 % 16, place % 16], kind });
            }
        }
        let distinct = |fingerprint: &dyn Fn(&CellKey) -> u64| {
            keys.iter().map(fingerprint).collect::<std::collections::HashSet<u64>>().len()
        };
        assert_eq!(distinct(&CellKey::fingerprint), keys.len());
        let faulty = |key: &CellKey| {
            let first = (u64::from(key.kind) ^ (key.cube[0] as u64) << PART_BIT).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            first ^ (key.cube[1] as u64) << 20 ^ (key.cube[2] as u64) << 40
        };
        assert!(distinct(&faulty) < keys.len() / 4);
    }

    #[test]
    fn all_cells_are_found_again_as_the_table_grows() {
        let mut grid = grid();
        let place =
            |index: usize| lookup(DVec3::new((index % 60) as f64, (index / 60) as f64, 0.0) / 15.0, DVec3::Z, 0.1);
        let cell = |grid: &mut CellGrid, index: usize| {
            let key = grid.key(&place(index), |_| true);
            grid.cell(key)
        };
        let found: Vec<u32> = (0..3600).map(|index| cell(&mut grid, index)).collect();
        assert!(grid.len() > 3000);
        assert!((0..3600).all(|index| cell(&mut grid, index) == found[index]));
    }
}
