//! Rooms made by rule from a kind and a seed: many rooms, none of which anything was built for.
//!
//! The same kind and seed give the same files on every machine. Nothing is read or written here.

mod dice;
mod draft;
mod furniture;
mod lamps;
mod offices;
mod passages;
mod places;
mod shapes;
mod solid;
mod stores;

pub use dice::Dice;
pub use draft::RoomFile;

use draft::Draft;

/// Name of the scene file among the files of a room.
pub const SCENE_FILE: &str = "room.json";

/// A kind of room.
#[derive(Clone, Copy)]
pub struct Kind {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is, in one line.
    pub what: &'static str,
    furnish: fn(&mut Draft, &mut Dice),
}

/// All kinds of rooms.
pub const KINDS: &[Kind] = &[
    Kind { name: "furnished", what: "desks, chairs on legs, cupboards, ceiling panels", furnish: offices::furnished },
    Kind { name: "uplit", what: "lit by way of the ceiling alone", furnish: offices::uplit },
    Kind { name: "white", what: "reflectances of about 0.9 all over", furnish: offices::white },
    Kind { name: "dark", what: "reflectances of 0.02 to 0.12, with furniture", furnish: offices::dark },
    Kind { name: "glossy", what: "Phong floor and furniture, a mirror on a wall", furnish: offices::glossy },
    Kind { name: "coffers", what: "panels at the bottom of deep coffers in the ceiling", furnish: offices::coffers },
    Kind { name: "panes", what: "a glass partition, lampshades that let light through", furnish: offices::panes },
    Kind { name: "shelves", what: "rows of open shelves with goods and narrow aisles", furnish: stores::shelves },
    Kind { name: "many-things", what: "small boxes by the thousand", furnish: stores::many_things },
    Kind {
        name: "hall",
        what: "a hall of racks: tens of thousands of triangles, some 100 lamps",
        furnish: stores::hall,
    },
    Kind { name: "corridor", what: "a corridor with doors in niches", furnish: passages::corridor },
    Kind { name: "long-thin", what: "45 to 80 m long, 1.2 to 2 m wide, few lamps", furnish: passages::long_thin },
    Kind {
        name: "door-ajar",
        what: "two rooms, one lit, a door open by a hand's breadth",
        furnish: passages::door_ajar,
    },
    Kind { name: "stairs", what: "a stairwell with flights and landings", furnish: passages::stairs },
    Kind { name: "one-spotlight", what: "a single narrow spotlight", furnish: lamps::one_spotlight },
    Kind { name: "dim-and-bright", what: "many dim lamps and a very bright one", furnish: lamps::dim_and_bright },
    Kind { name: "attic", what: "a sloped roof, stray triangles by the hundred", furnish: shapes::attic },
    Kind { name: "curved", what: "a vault, columns, balls, a curved bench", furnish: shapes::curved },
    Kind {
        name: "faulty-input",
        what: "T-junctions, faces that stand twice or face the other way",
        furnish: shapes::faulty_input,
    },
];

/// The kind of a name.
pub fn kind_of(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// A room as the files that describe it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Room {
    /// Name of its kind.
    pub kind: &'static str,
    /// Its seed.
    pub seed: u64,
    /// Text of the scene file.
    pub scene: String,
    /// The files that the scene file names.
    pub files: Vec<RoomFile>,
}

impl Kind {
    /// The room of a seed.
    pub fn room(&'static self, seed: u64) -> Room {
        let mut dice = Dice::new(self.name, seed);
        let mut draft = Draft::default();
        (self.furnish)(&mut draft, &mut dice);
        places::add_points(&mut draft, &mut dice);
        let (scene, files) = draft.finish(&format!("Proving ground: {}, seed {seed}", self.name));
        Room { kind: self.name, seed, scene, files }
    }
}

impl Room {
    /// Name of the room, for tables and folders.
    pub fn name(&self) -> String {
        format!("{}-{}", self.kind, self.seed)
    }
}
