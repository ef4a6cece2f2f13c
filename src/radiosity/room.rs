//! Converts a scene to a rectangular room, or refuses it with the reason.

use glam::DVec3;

use super::error::{NotARoom, refuse};
use super::faces::{ON_FACE, RoomFace, common_face};
use super::sources::RoomSource;
use crate::sampling::emitter::{Emitter, Emitters};
use crate::scene::{BsdfParameters, Emission, Scene};

/// Maximum number of rectangles of a room. Each one cuts the mesh of all faces.
const MOST_RECTANGLES: usize = 64;

/// A rectangle of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    pub face: RoomFace,
    /// Extent along the face's other two axes, in the room's coordinates, m.
    pub stretches: [[f64; 2]; 2],
    pub reflectance: f64,
    surface: u32,
}

/// A light source of a room.
pub(super) enum Lamp {
    /// An isotropic point or a panel.
    Source(RoomSource),
    /// A point with a directional distribution, and the face that it lies on, if any.
    Directed(Box<Emitter>, Option<RoomFace>),
}

/// A closed rectangular room. Its low corner is the origin of its own coordinates.
pub(super) struct BoxedRoom {
    /// Low corner in the scene's coordinates, m.
    pub corner_m: DVec3,
    pub size_m: [f64; 3],
    /// Coordinates along each axis at which tiles meet, including the room's ends, m.
    pub breaks: [Vec<f64>; 3],
    pub tiles: Vec<Tile>,
    /// Face of each triangle of the scene.
    pub faces: Vec<RoomFace>,
    pub lamps: Vec<Lamp>,
}

const A_ROOM: &str =
    "a closed room of diffuse rectangles along the axes, in which no surface hides another, such as one inward box";

impl BoxedRoom {
    /// Recognises a scene as a room, or refuses it.
    pub fn of(scene: &Scene) -> Result<BoxedRoom, NotARoom> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for triangle in 0..scene.triangles.len() as u32 {
            for corner in scene.corners_m(triangle) {
                low = low.min(corner);
                high = high.max(corner);
            }
        }
        let size_m = (high - low).to_array();
        let mut room = BoxedRoom {
            corner_m: low,
            size_m,
            breaks: size_m.map(|length| vec![0.0, length]),
            tiles: Vec::new(),
            faces: Vec::with_capacity(scene.triangles.len()),
            lamps: Vec::new(),
        };
        if size_m.iter().any(|length| *length <= 0.0) {
            return refuse("an open scene", "all surfaces in one plane".to_owned(), A_ROOM);
        }
        room.place_triangles(scene)?;
        room.pair_triangles(scene)?;
        room.check_closed()?;
        room.find_lamps(scene)?;
        room.check_receivers(scene)?;
        Ok(room)
    }

    fn tolerance_m(&self) -> f64 {
        ON_FACE * DVec3::from_array(self.size_m).max_element()
    }

    fn place_triangles(&mut self, scene: &Scene) -> Result<(), NotARoom> {
        for triangle in 0..scene.triangles.len() as u32 {
            let surface = scene.surface_of(triangle);
            let corners = scene.corners_m(triangle).map(|corner| corner - self.corner_m);
            let got = || format!("\"{}\"", surface.name);
            let Some(face) = common_face(self.size_m, &corners) else {
                return refuse("surfaces inside a room, or not along the axes", got(), A_ROOM);
            };
            if scene.triangle_normal(triangle).dot(face.normal()) < 0.5 {
                return refuse("surfaces that face away from the room", got(), A_ROOM);
            }
            if surface.two_sided {
                return refuse("two-sided surfaces", got(), "surfaces that face the room with their front only");
            }
            self.faces.push(face);
        }
        Ok(())
    }

    /// Combines pairs of triangles that divide one rectangle along a diagonal into tiles.
    fn pair_triangles(&mut self, scene: &Scene) -> Result<(), NotARoom> {
        let tolerance_m = self.tolerance_m();
        let mut halves: Vec<(Tile, DVec3)> = Vec::new();
        for triangle in 0..scene.triangles.len() as u32 {
            let face = self.faces[triangle as usize];
            let corners = scene.corners_m(triangle).map(|corner| corner - self.corner_m);
            let stretches = face.other_axes().map(|axis| {
                let along = corners.map(|corner| corner[axis]);
                [along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(0.0, f64::max)]
            });
            let surface = scene.triangle_surfaces[triangle as usize];
            let material = &scene.materials[scene.surfaces[surface as usize].material as usize];
            let BsdfParameters::Diffuse { reflectance } = material.bsdf else {
                return refuse("a surface that is not diffuse", format!("material \"{}\"", material.name), A_ROOM);
            };
            let tile = Tile { face, stretches, reflectance, surface };
            let centroid = corners.iter().sum::<DVec3>() / 3.0;
            let same = |(other, middle): &(Tile, DVec3)| {
                let apart = other.stretches.as_flattened().iter().zip(stretches.as_flattened());
                other.face == face
                    && other.surface == surface
                    && apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) <= tolerance_m
                    && middle.distance(centroid) > 10.0 * tolerance_m
            };
            let other = halves.iter().position(same);
            if halves.len() + self.tiles.len() > MOST_RECTANGLES {
                let got = format!("\"{}\"", scene.surface_of(triangle).name);
                return refuse(&format!("more than {MOST_RECTANGLES} rectangles, or other shapes"), got, A_ROOM);
            }
            match other {
                Some(place) => {
                    halves.swap_remove(place);
                    self.tiles.push(tile);
                }
                None => halves.push((tile, centroid)),
            }
        }
        let is_half = |tile: &Tile| tile.stretches.iter().all(|s| s[1] - s[0] > tolerance_m);
        match halves.first().or(None) {
            Some((half, _)) => {
                let name = format!("\"{}\"", scene.surfaces[half.surface as usize].name);
                refuse("surfaces that are not rectangles along the axes", name, A_ROOM)
            }
            None if self.tiles.iter().all(is_half) => {
                for tile in &self.tiles {
                    for (axis, stretch) in tile.face.other_axes().into_iter().zip(tile.stretches) {
                        for place in stretch {
                            if self.breaks[axis].iter().all(|other| (other - place).abs() > tolerance_m) {
                                self.breaks[axis].push(place);
                            }
                        }
                    }
                }
                self.breaks.iter_mut().for_each(|breaks| breaks.sort_by(f64::total_cmp));
                Ok(())
            }
            None => refuse("slivers", "a rectangle without width".to_owned(), A_ROOM),
        }
    }

    /// Checks that every cell of the breaks on every face lies on exactly one tile.
    fn check_closed(&self) -> Result<(), NotARoom> {
        for face in RoomFace::ALL {
            let [u, v] = face.other_axes().map(|axis| &self.breaks[axis]);
            for a in u.windows(2) {
                for b in v.windows(2) {
                    let middle = [0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1])];
                    let count = self.tiles.iter().filter(|tile| tile.face == face && tile.holds(middle)).count();
                    if count != 1 {
                        let what = if count == 0 { "an open scene" } else { "overlapping surfaces" };
                        let at = face.position(self.size_m, middle) + self.corner_m;
                        return refuse(what, format!("{count} surfaces at {at} m"), A_ROOM);
                    }
                }
            }
        }
        Ok(())
    }

    /// Reflectance at a point of a face.
    pub fn reflectance(&self, face: RoomFace, place: [f64; 2]) -> f64 {
        let tile = self.tiles.iter().find(|tile| tile.face == face && tile.holds(place));
        tile.map_or(0.0, |tile| tile.reflectance)
    }

    /// The face on which a position lies, within the tolerance of files.
    pub fn face_at(&self, position: DVec3) -> Option<RoomFace> {
        common_face(self.size_m, &[position])
    }

    fn is_outside(&self, position: DVec3) -> bool {
        let tolerance_m = self.tolerance_m();
        (0..3).any(|axis| position[axis] < -tolerance_m || position[axis] > self.size_m[axis] + tolerance_m)
    }

    fn find_lamps(&mut self, scene: &Scene) -> Result<(), NotARoom> {
        const WITHIN: &str = "luminaires within the room";
        for luminaire in &scene.luminaires {
            let got = format!("\"{}\"", luminaire.name);
            match &luminaire.emission {
                Emission::Isotropic { position_m, intensity_cd } => {
                    let position = *position_m - self.corner_m;
                    if self.is_outside(position) || self.face_at(position).is_some() {
                        return refuse("a point luminaire outside the room or in a surface", got, WITHIN);
                    }
                    let intensity_cd = *intensity_cd;
                    self.lamps.push(Lamp::Source(RoomSource::Point { position, intensity_cd }));
                }
                Emission::Lambertian { position_m, axis: aim, .. }
                | Emission::Photometric { position_m, frame: [_, _, aim], .. } => {
                    self.check_directed(*position_m, *aim, got)?;
                }
                Emission::Area { back: true, .. } => {
                    return refuse("luminaires that emit from the back of surfaces", got, WITHIN);
                }
                Emission::Area { surfaces, exitance_lm_m2, .. } => {
                    for tile in self.tiles.iter().filter(|tile| surfaces.contains(&tile.surface)) {
                        let [u, v] = tile.stretches;
                        let (low, high, exitance_lm_m2) = ([u[0], v[0]], [u[1], v[1]], *exitance_lm_m2);
                        self.lamps.push(Lamp::Source(RoomSource::Panel { face: tile.face, low, high, exitance_lm_m2 }));
                    }
                }
                emission if emission.is_daylight() => return refuse("sky or sun", got, A_ROOM),
                emission if emission.black_ball_m().is_some() => {
                    return refuse("luminaires that block light", got, "points and surfaces that emit");
                }
                emission => {
                    let what = format!("luminaires of kind {}", emission.kind_name());
                    return refuse(&what, got, "points, photometric luminaires and surfaces that emit");
                }
            }
        }
        for emitter in Emitters::of(scene).list() {
            let emission = &scene.luminaires[emitter.luminaire as usize].emission;
            if let Emission::Lambertian { position_m, .. } | Emission::Photometric { position_m, .. } = emission {
                let face = self.face_at(*position_m - self.corner_m);
                self.lamps.push(Lamp::Directed(Box::new(emitter.clone()), face));
            }
        }
        Ok(())
    }

    fn check_directed(&self, position_m: DVec3, aim: DVec3, got: String) -> Result<(), NotARoom> {
        let position = position_m - self.corner_m;
        let away = self.face_at(position).is_some_and(|face| face.normal().dot(aim) <= 0.0);
        if self.is_outside(position) || away {
            return refuse(
                "luminaires outside the room",
                got,
                "luminaires within the room, or on a face and aimed into it",
            );
        }
        Ok(())
    }

    fn check_receivers(&self, scene: &Scene) -> Result<(), NotARoom> {
        for set in &scene.receivers {
            if !set.quantity.is_illuminance() {
                let got = format!("\"{}\" of type {}", set.name, set.quantity.name());
                return refuse("what an observer sees", got, "receivers of type grid or points");
            }
            for point in set.points.iter().filter(|point| !point.inside) {
                let position = point.position_m - self.corner_m;
                let away = self.face_at(position).is_some_and(|face| face.normal().dot(point.normal) < -0.5);
                if self.is_outside(position) || away {
                    let got = format!("a point of \"{}\" at {} m", set.name, point.position_m);
                    return refuse("receivers outside the room", got, "points within the room or on its faces");
                }
            }
        }
        Ok(())
    }

    /// A position of the scene in the room's coordinates. Points that lie on a face within the tolerance of files are moved exactly
    /// onto it.
    pub fn settle(&self, position_m: DVec3) -> DVec3 {
        let tolerance_m = self.tolerance_m();
        let mut position = (position_m - self.corner_m).to_array();
        for (x, length) in position.iter_mut().zip(self.size_m) {
            if *x <= tolerance_m {
                *x = 0.0;
            } else if *x >= length - tolerance_m {
                *x = length;
            }
        }
        DVec3::from_array(position)
    }
}

impl Tile {
    fn holds(&self, place: [f64; 2]) -> bool {
        self.stretches.iter().zip(place).all(|(s, x)| s[0] <= x && x <= s[1])
    }
}
