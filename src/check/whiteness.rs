//! How much of the light in a room is absorbed or leaves through openings. If this is almost nothing, no chain ends within a reasonable
//! time.

use std::collections::{BTreeMap, HashSet};
use std::f64::consts::PI;

use glam::DVec3;

use super::box_tree::{BoxTree, Budget};
use super::insides::Enclosures;
use super::open_rooms::OpenRooms;
use super::shells::{Shell, one_vertex_a_place, shells_over};
use crate::scene::{Node, Scene, SceneError, Surface};

/// Least mean share that surfaces absorb and openings let out. Below it a packet meets more than 10,000 surfaces, and even pilots do not
/// end within a reasonable time. It is slightly below one ten-thousandth, because sums over a room with ρ = 0.9999 round.
const LEAST_ABSORBED: f64 = 0.9999e-4;

/// Tests of boxes and triangles in all, and additional tests per triangle and luminaire: a few seconds' work.
const TESTS: u64 = 100_000_000;
const TESTS_A_THING: u64 = 200;

/// How little of the light in a room is lost.
#[derive(Clone, Copy, Debug)]
struct RoomLoss {
    /// Mean share, weighted by area, that surfaces absorb and openings let out.
    pub share: f64,
    /// Area of openings in m²; 0 for a closed room.
    pub openings_m2: f64,
}

/// Results of the search for rooms with nearly white surfaces.
#[derive(Debug, Default)]
struct Losses {
    /// The least loss among all rooms around a luminaire.
    pub least: Option<RoomLoss>,
    /// Whether all rooms were examined.
    pub all_examined: bool,
}

/// Finds rooms, closed or with small openings, that lose almost none of the light in them.
fn least_loss(scene: &Scene) -> Losses {
    if scene.surfaces.iter().all(|surface| absorbed_by(scene, surface) >= LEAST_ABSORBED) {
        return Losses { least: None, all_examined: true };
    }
    let things = scene.triangles.len() + scene.luminaires.len();
    let mut budget = Budget::of_steps(TESTS + TESTS_A_THING * things as u64);
    let vertex_of = one_vertex_a_place(scene);
    let shells = shells_over(scene, &vertex_of);
    let mut search = Search {
        scene,
        shells: &shells,
        boxes: BoxTree::of(shells.iter().map(Shell::bounds_m)),
        step_m: 0.0,
        open_rooms: OpenRooms::of(scene, &shells, &vertex_of, &mut budget),
        budget,
    };
    let least = search.least();
    Losses { least, all_examined: !search.budget.is_spent() }
}

/// Refuses a scene with a room that loses almost none of the light in it.
pub(super) fn refuse_white_rooms(geometry: &Node, scene: &mut Scene) -> Result<(), SceneError> {
    let losses = least_loss(scene);
    if !losses.all_examined {
        scene.warnings.push("too many white rooms to check which of them lose almost no light".to_owned());
    }
    if let Some(loss) = losses.least.filter(|loss| loss.share < LEAST_ABSORBED) {
        let share = if loss.share > 0.0 { format!("{:.1e}", loss.share) } else { "nothing".to_owned() };
        let (what, got) = if loss.openings_m2 > 0.0 {
            (
                "a room that absorbs almost nothing, with openings that let almost no light out",
                format!(
                    "the surfaces around a luminaire lose {share} of the light that falls on them, by absorption and through openings of {:.1e} m²: light hits about {:.0e} surfaces",
                    loss.openings_m2,
                    loss.share.recip()
                ),
            )
        } else {
            (
                "a closed room that absorbs almost nothing",
                format!(
                    "the surfaces around a luminaire absorb {share} of the light that falls on them, and no light can leave"
                ),
            )
        };
        return Err(geometry.refuse_as(
            what,
            got,
            format!(
                "surfaces that absorb {LEAST_ABSORBED:.0e} or more on average, or an opening of this share of their area"
            ),
            "lower a reflectance: light would be reflected for ever, or nearly so; the whitest paints have 0.99",
        ));
    }
    Ok(())
}

/// A room around a luminaire.
#[derive(Clone, Copy)]
enum RoomAround<'s> {
    Closed(&'s Shell),
    /// A room with openings, and the least share of all directions at one of its luminaires that it covers.
    Open(u32, f64),
}

struct Search<'s> {
    scene: &'s Scene,
    shells: &'s [Shell],
    boxes: BoxTree,
    step_m: f64,
    open_rooms: OpenRooms<'s>,
    budget: Budget,
}

impl<'s> Search<'s> {
    fn least(&mut self) -> Option<RoomLoss> {
        let enclosures = Enclosures::of(self.scene, self.shells);
        self.step_m = enclosures.step_m();
        let lit = self.scene.luminaires.iter().filter(|luminaire| luminaire.luminous_flux_lm > 0.0);
        let mut closed: Vec<&Shell> = Vec::new();
        let mut known: HashSet<*const Shell> = HashSet::new();
        let mut open: BTreeMap<u32, f64> = BTreeMap::new();
        for start_m in lit.flat_map(|luminaire| enclosures.starts_m(&luminaire.emission)) {
            if let Some(room) = enclosures.smallest_around(start_m, &mut self.budget) {
                if known.insert(room) {
                    closed.push(room);
                }
            } else if let Some(room) = self.open_rooms.around(start_m, &mut self.budget) {
                let sky_share = self.open_rooms.sky_share(room, start_m, &mut self.budget);
                open.entry(room).and_modify(|least| *least = least.min(sky_share)).or_insert(sky_share);
            }
        }
        let closed = closed.into_iter().map(RoomAround::Closed);
        let rooms = closed.chain(open.into_iter().map(|(room, sky_share)| RoomAround::Open(room, sky_share)));
        let mut least: Option<RoomLoss> = None;
        for room in rooms {
            let loss = self.loss_in(room);
            if self.budget.is_spent() {
                break;
            }
            if least.is_none_or(|least| loss.share < least.share) {
                least = Some(loss);
            }
        }
        least
    }

    fn is_in(&mut self, room: RoomAround, point_m: DVec3) -> bool {
        match room {
            RoomAround::Closed(shell) => shell.winding_within(point_m, &mut self.budget).abs() > 0.5,
            RoomAround::Open(room, _) => self.open_rooms.sky_share(room, point_m, &mut self.budget) > 0.5,
        }
    }

    fn loss_in(&mut self, room: RoomAround) -> RoomLoss {
        let (bounds_m, openings_m2, sky_share) = match room {
            RoomAround::Closed(shell) => (shell.bounds_m(), 0.0, 1.0),
            RoomAround::Open(room, sky) => (self.open_rooms.bounds_m(room), self.open_rooms.openings_m2(room), sky),
        };
        let (scene, shells) = (self.scene, self.shells);
        let mut sums = AbsorptionSums::default();
        sums.add(openings_m2, 1.0);
        let mut near: Vec<u32> = Vec::new();
        self.boxes.meeting(bounds_m, &mut self.budget, |number| near.push(number));
        near.sort_unstable();
        for number in near {
            let shell = &shells[number as usize];
            let is_of_room = match room {
                RoomAround::Closed(own) => std::ptr::eq(shell, own),
                RoomAround::Open(own, _) => self.open_rooms.has(own, number),
            };
            let step_m = self.step_m;
            sums.add_shell(scene, shell, step_m, &mut |point_m| {
                self.is_in(room, point_m)
                    && (is_of_room || shell.winding_within(point_m, &mut self.budget).abs() <= 0.5)
            });
            if self.budget.is_spent() {
                break;
            }
        }
        for luminaire in &scene.luminaires {
            if let Some((center_m, radius_m)) = luminaire.emission.black_ball_m()
                && self.budget.take(1)
                && self.is_in(room, center_m)
            {
                sums.add(4.0 * PI * radius_m * radius_m, 1.0);
            }
        }
        // The share of directions that is open at a luminaire is a lower bound of the loss, however the rim of the opening was interpreted.
        let share = (sums.absorbed_m2 / sums.area_m2).max(1.0 - sky_share);
        RoomLoss { share, openings_m2 }
    }
}

/// Returns the share of the light on a surface's front that the surface absorbs.
fn absorbed_by(scene: &Scene, surface: &Surface) -> f64 {
    1.0 - scene.materials[surface.material as usize].bsdf.returned_share()
}

/// An area, and how much of it absorbs.
#[derive(Default)]
struct AbsorptionSums {
    area_m2: f64,
    absorbed_m2: f64,
}

impl AbsorptionSums {
    fn add(&mut self, area_m2: f64, absorbed: f64) {
        self.area_m2 += area_m2;
        self.absorbed_m2 += absorbed * area_m2;
    }

    /// Adds the sides of a shell that light of a room can reach.
    fn add_shell(&mut self, scene: &Scene, shell: &Shell, step_m: f64, is_lit: &mut impl FnMut(DVec3) -> bool) {
        for triangle in &shell.triangles {
            let surface = scene.surface_of(*triangle);
            let middle_m = scene.corners_m(*triangle).iter().sum::<DVec3>() / 3.0;
            let area_m2 = scene.triangle_area_m2(*triangle);
            let step = step_m * scene.triangle_normal(*triangle);
            let front = absorbed_by(scene, surface);
            let back = if surface.two_sided { front } else { 1.0 };
            for (side_m, absorbed) in [(middle_m + step, front), (middle_m - step, back)] {
                if is_lit(side_m) {
                    self.add(area_m2, absorbed);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::check::scene_from_json;

    fn read(white: f64, rest: &str) -> Result<(), String> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": {white} }}, "grey": {{ "type": "diffuse", "reflectance": 0.2 }} }},
            "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "white" }} {rest} ],
            "luminaires": [ {{ "name": "lamp", "type": "point", "position": [2,2,2.5], "luminous_flux_lm": 1000 }} ] }}"#
        );
        scene_from_json(&text, None, std::path::Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
    }

    fn chest(min: [f64; 3], edge_m: f64, material: &str) -> String {
        let max = min.map(|low| low + edge_m);
        format!(r#", {{ "name": "chest", "type": "box", "min": {min:?}, "max": {max:?}, "material": "{material}" }}"#)
    }

    /// A grey chest of 10 cm in a room of 80 m² absorbs 0.8 · 0.06 / 80.06 = 6e-4 of the light; one of 1 cm absorbs a hundredth of that.
    #[test]
    fn a_white_room_needs_enough_that_absorbs_in_it() {
        assert!(read(1.0, &chest([1.0, 1.0, 1.0], 0.1, "grey")).is_ok());
        let refused = read(1.0, &chest([1.0, 1.0, 1.0], 0.01, "grey")).expect_err("nearly nothing absorbs");
        assert!(refused.contains("6.0e-6") && refused.contains("absorbs almost nothing"), "{refused}");
    }

    #[test]
    fn what_stands_outside_of_a_room_absorbs_nothing_of_its_light() {
        let around = r#", { "name": "house", "type": "box", "min": [-1,-1,-1], "max": [9,9,9], "facing": "inward", "material": "grey" }"#;
        assert!(read(1.0, around).is_err());
        assert!(read(0.9999, around).is_ok());
        assert!(read(1.0, &chest([5.0, 5.0, 1.0], 1.0, "grey")).is_err());
    }

    /// Reads a room of nine white rectangles, 2 m wide, with a square opening of `edge_m` in the ceiling, and more in it.
    fn with_opening(edge_m: f64, rest: &str) -> Result<(), String> {
        let rectangle = |name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3]| {
            format!(
                r#"{{ "name": "{name}", "type": "rectangle", "origin": {origin:?}, "u": {u:?}, "v": {v:?}, "material": "white" }}"#
            )
        };
        let (from, to) = (1.0 - 0.5 * edge_m, 1.0 + 0.5 * edge_m);
        let walls = [
            rectangle("floor", [0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
            rectangle("south", [0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0]),
            rectangle("north", [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]),
            rectangle("west", [0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]),
            rectangle("east", [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0]),
            rectangle("low x", [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], [from, 0.0, 0.0]),
            rectangle("high x", [to, 0.0, 2.0], [0.0, 2.0, 0.0], [2.0 - to, 0.0, 0.0]),
            rectangle("low y", [from, 0.0, 2.0], [0.0, from, 0.0], [to - from, 0.0, 0.0]),
            rectangle("high y", [from, to, 2.0], [0.0, 2.0 - to, 0.0], [to - from, 0.0, 0.0]),
        ];
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 1 }}, "grey": {{ "type": "diffuse", "reflectance": 0.2 }} }},
            "geometry": [ {} {rest} ],
            "luminaires": [ {{ "name": "lamp", "type": "point", "position": [1.2,0.9,1], "luminous_flux_lm": 1000 }} ] }}"#,
            walls.join(", ")
        );
        scene_from_json(&text, None, std::path::Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
    }

    /// The opening takes this part of the 24 m² of a cube; walks end after the inverse of it.
    #[test]
    fn an_opening_counts_as_what_absorbs_all() {
        for part in [1e-2, 1e-3, 2e-4] {
            assert!(with_opening((24.0f64 * part).sqrt(), "").is_ok(), "{part}");
        }
        for part in [5e-5, 1e-5, 1e-6, 1e-9] {
            let refused = with_opening((24.0f64 * part).sqrt(), "").expect_err("nearly closed");
            assert!(refused.contains("openings") && refused.contains("nearly so"), "{refused}");
        }
        // Things in the room count as in a closed room: a grey chest of 1 dm suffices, a white one does not.
        assert!(with_opening(1e-3, &chest([0.2, 0.2, 0.2], 0.1, "grey")).is_ok());
        assert!(with_opening(1e-3, &chest([0.2, 0.2, 0.2], 0.1, "white")).is_err());
        // A white one-sided sheet has a back, which absorbs. A sheet with two white sides has none, and encloses nothing.
        let sheet = r#", { "name": "sheet", "type": "rectangle", "origin": [0.5,0.5,0.5], "u": [0.5,0,0], "v": [0,0.5,0], "material": "white" }"#;
        assert!(with_opening(1e-3, sheet).is_ok());
        assert!(with_opening(1e-3, &sheet.replace(r#""material""#, r#""two_sided": true, "material""#)).is_err());
    }

    /// White things that light can pass around freely do not form a room.
    #[test]
    fn white_things_in_the_open_are_read() {
        let read = |geometry: &str, height: f64| {
            let text = format!(
                r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 1 }} }}, "geometry": [ {geometry} ],
                "luminaires": [ {{ "name": "lamp", "type": "point", "position": [0.1,0,{height}], "luminous_flux_lm": 1000 }} ] }}"#
            );
            scene_from_json(&text, None, std::path::Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
        };
        let sheet = |z: f64, v: f64| {
            format!(
                r#"{{ "name": "sheet {z}", "type": "rectangle", "origin": [-9,{},{z}], "u": [18,0,0], "v": [0,{v},0], "material": "white" }}"#,
                -0.5 * v
            )
        };
        assert_eq!(read(&sheet(0.0, 18.0), 1.0), Ok(()));
        assert_eq!(read(&format!("{}, {}", sheet(0.0, 18.0), sheet(1.0, -18.0)), 0.5), Ok(()));
        assert_eq!(
            read(r#"{ "name": "ball", "type": "sphere", "center": [0,0,0], "radius": 1, "material": "white" }"#, 2.0),
            Ok(())
        );
    }

    /// The back of a one-sided sheet absorbs all light that falls on it.
    #[test]
    fn backs_of_sheets_absorb() {
        let sheet = r#", { "name": "sheet", "type": "rectangle", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "material": "white" }"#;
        assert!(read(1.0, sheet).is_ok());
        let both = sheet.replace(r#""material""#, r#""two_sided": true, "material""#);
        assert!(read(1.0, &both).is_err());
    }
}
