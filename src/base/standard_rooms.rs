//! UGR tables: the standard rooms of CIE 190:2010, their background luminance by the tabular method, and the glare sum of luminaires there.
//!
//! The luminaires are H = 2 m above the observer's eye. The observer sits at the middle of a wall and looks across the room. Luminaires
//! stand in rows at a distance S, the outermost S/2 from the walls.

use glam::{DMat3, DVec3};

use super::form_factors::{AxisRectangle, exchange_m2};
use super::glare::unified_glare_rating;
use super::position_index::position_index;

/// H: height of the luminaires above the eye in m.
pub const HEIGHT_M: f64 = 2.0;
/// Spacing of the luminaires in tables, over H.
pub const TABLE_SPACING_H: f64 = 0.25;
/// Reflectances of ceiling, walls and reference plane in tables.
pub const TABLE_REFLECTANCES: [[f64; 3]; 5] =
    [[0.7, 0.5, 0.2], [0.7, 0.3, 0.2], [0.5, 0.5, 0.2], [0.5, 0.3, 0.2], [0.3, 0.3, 0.2]];
/// Number of zones of 10° that describe the light of a luminaire, γ from 0° to 180°.
pub const ZONES: usize = 18;

/// A standard room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardRoom {
    /// X, across the line of sight, and Y, along it, both over H.
    pub size_h: [f64; 2],
    /// Geometric multipliers: the direct flux on the reference plane is the sum of their products with the fluxes within four cones.
    multipliers: [f64; 4],
}

const fn room(across: u8, along: u8, multipliers: [f64; 4]) -> StandardRoom {
    StandardRoom { size_h: [across as f64, along as f64], multipliers }
}

/// The nineteen rooms of a table, with the multipliers F_GL of CIE 190, table 4.
///
/// Four numbers per room give the direct flux of any luminaire. For Lambertian luminaires at a spacing of H the result agrees within 0.001.
pub const STANDARD_ROOMS: [StandardRoom; 19] = [
    room(2, 2, [0.690, 0.109, 0.085, -0.016]),
    room(2, 3, [0.578, 0.200, 0.127, -0.018]),
    room(2, 4, [0.528, 0.218, 0.170, -0.017]),
    room(2, 6, [0.485, 0.215, 0.222, -0.012]),
    room(2, 8, [0.466, 0.207, 0.249, -0.006]),
    room(2, 12, [0.448, 0.198, 0.272, 0.005]),
    room(4, 2, [0.528, 0.218, 0.170, -0.017]),
    room(4, 3, [0.394, 0.275, 0.268, -0.020]),
    room(4, 4, [0.338, 0.257, 0.351, -0.018]),
    room(4, 6, [0.296, 0.203, 0.449, -0.006]),
    room(4, 8, [0.280, 0.165, 0.499, 0.006]),
    room(4, 12, [0.264, 0.125, 0.541, 0.027]),
    room(8, 4, [0.280, 0.165, 0.499, 0.006]),
    room(8, 6, [0.248, 0.058, 0.628, 0.032]),
    room(8, 8, [0.239, -0.012, 0.690, 0.058]),
    room(8, 12, [0.232, -0.084, 0.740, 0.098]),
    room(12, 4, [0.264, 0.125, 0.541, 0.027]),
    room(12, 6, [0.238, -0.003, 0.677, 0.063]),
    room(12, 8, [0.232, -0.084, 0.740, 0.098]),
];

/// How the observer looks at the luminaires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewing {
    /// Across their length.
    Crosswise,
    /// Along their length.
    Endwise,
}

impl Viewing {
    /// Both, in the order of tables.
    pub const BOTH: [Viewing; 2] = [Viewing::Crosswise, Viewing::Endwise];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Viewing::Crosswise => "crosswise",
            Viewing::Endwise => "endwise",
        }
    }
}

/// Sum of glare from the luminaires of a room for the observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoomGlare {
    /// Σ L²ω/p² in cd²·sr/m⁴.
    pub sum: f64,
    /// Number of luminaires in the room.
    pub luminaires: u32,
    /// Number of luminaires that have a position index.
    pub counted: u32,
}

impl StandardRoom {
    /// Whether luminaires at a spacing, over H, fill the room evenly.
    pub fn fits(&self, spacing_h: f64) -> bool {
        self.rows(spacing_h).is_some()
    }

    /// Returns the numbers of luminaires across and along; `None` where the spacing does not divide the sides.
    fn rows(&self, spacing_h: f64) -> Option<[u32; 2]> {
        /// Largest deviation of a side from a whole number of spacings, as a fraction of one spacing: the rounding of 1/3.
        const WHOLE_WITHIN: f64 = 1e-6;
        let counts = self.size_h.map(|side_h| side_h / spacing_h);
        let is_whole = |count: f64| (count - count.round()).abs() < WHOLE_WITHIN && count.round() >= 1.0;
        counts.iter().all(|count| is_whole(*count)).then(|| counts.map(|count| count.round() as u32))
    }

    /// Returns the direct flux of one luminaire on the reference plane in lm, from its fluxes in zones of 10°.
    ///
    /// The cones of the multipliers end at 41.4°, 60°, 75.5° and 90°, which are quarters of the half space. Source: docs/methods.md (27).
    pub fn direct_flux_lm(&self, zone_fluxes_lm: &[f64; ZONES]) -> f64 {
        let within = |zones: usize| zone_fluxes_lm[..zones].iter().sum::<f64>();
        let cones_lm =
            [within(4) + 0.130 * zone_fluxes_lm[4], within(6), within(7) + 0.547 * zone_fluxes_lm[7], within(9)];
        self.multipliers.iter().zip(cones_lm).map(|(multiplier, flux_lm)| multiplier * flux_lm).sum()
    }

    /// Returns the mean indirect illuminance of the walls between reference plane and luminaires, in lx, per lm of direct flux on the
    /// reference plane, on the walls, and on the ceiling.
    ///
    /// The reflectances are those of ceiling, walls and reference plane; each is lit uniformly. Multiplied by the walls' area, the results
    /// are the transfer factors F_T,FW, F_T,WW − 1 and F_T,CW of CIE 190, table 5. They agree with the table to within its rounding.
    pub fn transfer_per_m2(&self, reflectances: [f64; 3]) -> [f64; 3] {
        let [x_m, y_m] = self.size_h.map(|side_h| side_h * HEIGHT_M);
        let plane = AxisRectangle { axis: 2, at_m: 0.0, faces_up: true, stretches_m: [[0.0, x_m], [0.0, y_m]] };
        let ceiling = AxisRectangle { axis: 2, at_m: HEIGHT_M, faces_up: false, ..plane };
        let floor_m2 = plane.area_m2();
        let walls_m2 = self.walls_m2();
        let across = exchange_m2(&plane, &ceiling) / floor_m2;
        let aside = 1.0 - across;
        let back = aside * floor_m2 / walls_m2;
        let [of_ceiling, of_walls, of_plane] = reflectances;
        // Column j holds the illuminance on each surface that 1 lx on surface j (ceiling, walls, plane) causes by one reflection.
        let reflected = DMat3::from_cols(
            of_ceiling * DVec3::new(0.0, back, across),
            of_walls * DVec3::new(aside, 1.0 - 2.0 * back, aside),
            of_plane * DVec3::new(across, back, 0.0),
        );
        let total = (DMat3::IDENTITY - reflected).inverse();
        let on_walls = total.row(1);
        [on_walls.z / floor_m2, (on_walls.y - 1.0) / walls_m2, on_walls.x / floor_m2]
    }

    /// Returns the area of the walls between reference plane and luminaires in m².
    pub fn walls_m2(&self) -> f64 {
        2.0 * HEIGHT_M * HEIGHT_M * (self.size_h[0] + self.size_h[1])
    }

    /// Returns the background luminance in cd/m² by the tabular method, for a number of luminaires with these fluxes in zones of 10°:
    /// docs/methods.md (26).
    pub fn background_cd_m2(&self, luminaires: u32, zone_fluxes_lm: &[f64; ZONES], reflectances: [f64; 3]) -> f64 {
        let downward_lm: f64 = zone_fluxes_lm[..ZONES / 2].iter().sum();
        let upward_lm: f64 = zone_fluxes_lm[ZONES / 2..].iter().sum();
        let on_plane_lm = self.direct_flux_lm(zone_fluxes_lm);
        let [from_plane, from_walls, from_ceiling] = self.transfer_per_m2(reflectances);
        let indirect_lx =
            on_plane_lm * from_plane + (downward_lm - on_plane_lm) * from_walls + upward_lm * from_ceiling;
        f64::from(luminaires) * indirect_lx / std::f64::consts::PI
    }

    /// Returns the glare sum of luminaires at a spacing, over H; `None` where they do not fit.
    ///
    /// `square_over_area` returns I²/A_projected in cd²/m² towards a direction along the luminaire's C0, C90 and γ = 0. In the crosswise
    /// view C0 faces the observer's wall, in the endwise view C90 does.
    pub fn glare(
        &self,
        spacing_h: f64,
        viewing: Viewing,
        square_over_area: impl Fn(DVec3) -> f64,
    ) -> Option<RoomGlare> {
        let [across, along] = self.rows(spacing_h)?;
        let mut glare = RoomGlare { sum: 0.0, luminaires: across * along, counted: 0 };
        for row in 0..along {
            for column in 0..across {
                let ahead_m = (f64::from(row) + 0.5) * spacing_h * HEIGHT_M;
                let aside_m = (f64::from(column) + 0.5 - 0.5 * f64::from(across)) * spacing_h * HEIGHT_M;
                let offset_m = DVec3::new(ahead_m, aside_m, HEIGHT_M);
                let Ok(index) = position_index(DVec3::X, offset_m) else {
                    continue;
                };
                let towards_eye = match viewing {
                    Viewing::Crosswise => DVec3::new(ahead_m, -aside_m, HEIGHT_M),
                    Viewing::Endwise => DVec3::new(aside_m, ahead_m, HEIGHT_M),
                };
                glare.counted += 1;
                glare.sum += square_over_area(towards_eye.normalize()) / (offset_m.length_squared() * index * index);
            }
        }
        Some(glare)
    }
}

/// Ratings of a luminaire in the standard rooms.
#[derive(Clone, Debug, PartialEq)]
pub struct UgrTable {
    /// Spacing of the luminaires over H.
    pub spacing_h: f64,
    /// Sets of reflectances of ceiling, walls and reference plane.
    pub reflectances: Vec<[f64; 3]>,
    /// The rooms in the order of [`STANDARD_ROOMS`].
    pub rooms: Vec<RatedRoom>,
}

/// A room of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct RatedRoom {
    /// X and Y over H.
    pub size_h: [f64; 2],
    /// Background luminance in cd/m² for each set of reflectances.
    pub backgrounds_cd_m2: Vec<f64>,
    /// Glare sums of the luminaires, seen crosswise and endwise.
    pub glare: [RoomGlare; 2],
}

impl SpacingCorrection {
    /// Returns the least and the greatest change over the rooms; `None` if there is none.
    pub fn range(&self, viewing: Viewing) -> Option<[f64; 2]> {
        let changes = self.rooms.iter().filter_map(|(_, change)| change[viewing as usize]);
        changes.fold(None, |range, change| {
            let [least, most] = range.unwrap_or([change; 2]);
            Some([change.min(least), change.max(most)])
        })
    }
}

impl RatedRoom {
    /// Returns the rating for a set of reflectances, given by its index; `None` where no luminaire shines into the eye.
    pub fn ugr(&self, viewing: Viewing, reflectances: usize) -> Option<f64> {
        unified_glare_rating(self.backgrounds_cd_m2[reflectances], self.glare[viewing as usize].sum)
    }
}

/// Change of the ratings where luminaires stand farther apart with the same light per floor area.
#[derive(Clone, Debug, PartialEq)]
pub struct SpacingCorrection {
    /// Spacing over H.
    pub spacing_h: f64,
    /// The rooms that the spacing fits: X and Y over H, and the change of UGR crosswise and endwise. `None` where no luminaire shines into
    /// the eye at one of the two spacings.
    pub rooms: Vec<([f64; 2], [Option<f64>; 2])>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::form_factors::point_parallel_corner;

    /// A Lambertian luminaire sends a rectangle below it its form factor, and 7, 12, 15 and 16 sixteenths into the four cones. For
    /// luminaires at a spacing of H, the multipliers of all rooms agree within 0.001. A multiplier 0.004 off, the planted fault, does not.
    #[test]
    fn the_multipliers_are_those_of_luminaires_h_apart() {
        for room in &STANDARD_ROOMS {
            let [x, y] = room.size_h;
            let mut sum = 0.0;
            for i in 0..x as u32 {
                for j in 0..y as u32 {
                    let (u, v) = (f64::from(i) + 0.5, f64::from(j) + 0.5);
                    let corner = |u: f64, v: f64| point_parallel_corner(u, v, 1.0);
                    sum += corner(x - u, y - v) - corner(-u, y - v) - corner(x - u, -v) + corner(-u, -v);
                }
            }
            let exact = sum / (x * y);
            let [a, b, c, d] = room.multipliers;
            let direct = (7.0 * a + 12.0 * b + 15.0 * c + 16.0 * d) / 16.0;
            assert!((direct - exact).abs() < 0.001, "{room:?}: {direct} {exact}");
            assert!((direct + 0.004 * 12.0 / 16.0 - exact).abs() > 0.001, "{room:?}");
        }
    }

    /// Cones are composed of zones. Of 1 lm in the zone from 40° to 50°, 0.130 lm lie within 41.4°. Of 1 lm in the zone from 70° to 80°,
    /// 0.547 lm lie within 75.5°. Both shares are linear in solid angle within 0.001.
    #[test]
    fn cones_are_gathered_from_zones() {
        for (zone, cone, edge) in [(4, 0, 0.75), (7, 2, 0.25f64)] {
            let cosine = |edge: usize| (10.0 * edge as f64).to_radians().cos();
            let share = (cosine(zone) - edge) / (cosine(zone) - cosine(zone + 1));
            let mut zones = [0.0; ZONES];
            zones[zone] = 1.0;
            let room = STANDARD_ROOMS[0];
            let whole: f64 = room.multipliers[cone + 1..].iter().sum();
            let own = (room.direct_flux_lm(&zones) - whole) / room.multipliers[cone];
            assert!((own - share).abs() < 0.001, "{own} {share}");
        }
    }

    /// Transfer factors of CIE 190, table 5, for the smallest, a middle, and the largest room, within 0.001: the last digit plus the error
    /// of the standard's own arithmetic.
    #[test]
    fn the_transfer_factors_are_those_of_the_standard() {
        let published = [
            (
                0,
                [
                    [0.220, 0.422, 0.646],
                    [0.188, 0.217, 0.553],
                    [0.198, 0.380, 0.445],
                    [0.172, 0.198, 0.386],
                    [0.157, 0.181, 0.227],
                ],
            ),
            (
                10,
                [
                    [0.115, 0.211, 0.307],
                    [0.106, 0.117, 0.283],
                    [0.100, 0.187, 0.211],
                    [0.093, 0.104, 0.196],
                    [0.081, 0.092, 0.114],
                ],
            ),
            (
                15,
                [
                    [0.071, 0.133, 0.183],
                    [0.067, 0.076, 0.174],
                    [0.061, 0.117, 0.125],
                    [0.058, 0.067, 0.120],
                    [0.049, 0.059, 0.069],
                ],
            ),
        ];
        for (place, rows) in published {
            let room = &STANDARD_ROOMS[place];
            for (reflectances, row) in TABLE_REFLECTANCES.iter().zip(rows) {
                for (own, factor) in room.transfer_per_m2(*reflectances).iter().zip(row) {
                    let own = own * room.walls_m2();
                    assert!((own - factor).abs() < 0.001, "{room:?} {reflectances:?}: {own} {factor}");
                }
            }
        }
    }

    /// The geometry worked out by hand: in 2H × 2H at a spacing of H, four luminaires stand at T/R, H/R = 1, 2 (outside the table) and 1/3,
    /// 2/3.
    #[test]
    fn the_luminaires_of_the_smallest_room_come_out_by_hand() {
        let glare = STANDARD_ROOMS[0].glare(1.0, Viewing::Crosswise, |_| 1.0).expect("it fits");
        assert_eq!((glare.luminaires, glare.counted), (4, 2));
        // Table 4.1 between T/R = 0.3 and 0.4, H/R = 0.6 and 0.7.
        let index = (2.0 * (3.25 + 2.0 * 3.90) / 3.0 + (3.30 + 2.0 * 3.90) / 3.0) / 3.0;
        let exact = 2.0 / (14.0 * index * index);
        assert!((glare.sum / exact - 1.0).abs() < 1e-12, "{} {exact}", glare.sum);
        assert!(!STANDARD_ROOMS[1].fits(2.0) && STANDARD_ROOMS[0].fits(1.0 / 3.0));
        assert!(STANDARD_ROOMS[0].glare(0.3, Viewing::Endwise, |_| 1.0).is_none());
    }

    /// C0 faces the observer crosswise, C90 endwise. Luminaires to the left and to the right are seen from opposite sides.
    #[test]
    fn luminaires_face_the_observer_as_asked() {
        let share = |viewing: Viewing, wanted: fn(DVec3) -> bool| {
            let all = STANDARD_ROOMS[10].glare(0.25, viewing, |_| 1.0).map_or(0.0, |glare| glare.sum);
            let some = STANDARD_ROOMS[10].glare(0.25, viewing, |to| f64::from(u8::from(wanted(to))));
            some.map_or(0.0, |glare| glare.sum) / all
        };
        assert!((share(Viewing::Crosswise, |to| to.x > 0.0) - 1.0).abs() < 1e-12);
        assert!((share(Viewing::Endwise, |to| to.y > 0.0) - 1.0).abs() < 1e-12);
        assert!((share(Viewing::Crosswise, |to| to.y > 0.0) - 0.5).abs() < 1e-12);
        assert!((share(Viewing::Endwise, |to| to.x > 0.0) - 0.5).abs() < 1e-12);
    }
}
