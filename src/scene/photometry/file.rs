//! The content of a photometric file, in one form for all formats.

use super::{IntensityWeb, PhotometricType};

/// Excess of the integrated over the declared flux, as a fraction, above which a warning is given. The trapezoidal integral of a coarse
/// table is wrong by tenths of a percent.
pub(super) const FLUX_TOLERANCE: f64 = 0.01;

/// The content of a photometric file: the final intensities, and the data of its header.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotometricFile {
    /// Intensities in cd, including every factor of the file; initial and undimmed.
    pub web: IntensityWeb,
    /// Format and edition.
    pub format: PhotometricFormat,
    /// Manufacturer; may be empty.
    pub manufacturer: String,
    /// Description or name of the luminaire; may be empty.
    pub luminaire: String,
    /// Catalogue number; may be empty.
    pub catalog_number: String,
    /// Description of the lamps; may be empty.
    pub lamp: String,
    /// Labels in the order of the file. For IES: keywords without brackets, with `[MORE]` joined to the text that it continues, and free
    /// lines under an empty keyword. For EULUMDAT: its text fields under their names.
    pub keywords: Vec<(String, String)>,
    /// Number of lamps in the header, without sign.
    pub lamps: f64,
    /// Rated flux of one lamp in lm; `None` in absolute photometry.
    pub lumens_per_lamp: Option<f64>,
    /// All standard sets of lamps of an EULUMDAT file, or the one set of an IES file. The first set applies.
    pub lamp_sets: Vec<LampSet>,
    /// Flux in lm that the header declares: of all lamps in relative photometry, of the luminaire in absolute photometry. `None` for
    /// absolute IES files, which declare none.
    pub declared_flux_lm: Option<f64>,
    /// Whether the intensities are absolute, not relative to the lamps' flux.
    pub absolute: bool,
    /// Electric power in W, ballast included, if the file gives a value above 0.
    pub power_w: Option<f64>,
    /// The luminous opening.
    pub opening: Opening,
    /// Which planes the file stores, and how the others follow.
    pub symmetry: LateralSymmetry,
    /// The goniometer of the file.
    pub photometric_type: PhotometricType,
    /// Ratio of the integrated flux to the lamps' flux, in relative photometry.
    pub light_output_ratio: Option<f64>,
    /// Code of IES LM-63-2019 for the origin of the data.
    pub file_generation_type: Option<f64>,
    /// Warnings of the reader for the user.
    pub warnings: Vec<String>,
}

/// One of the sets of lamps that a file lists.
#[derive(Clone, Debug, PartialEq)]
pub struct LampSet {
    /// Number of lamps in the set, without sign.
    pub lamps: f64,
    /// Flux in lm of all lamps of the set together (of the luminaire in absolute photometry); `None` if not declared.
    pub flux_lm: Option<f64>,
    /// Type of lamp.
    pub description: String,
    /// Colour appearance or temperature, as written.
    pub colour: String,
    /// Colour rendering, as written.
    pub colour_rendering: String,
    /// Power in W, ballast included, if given.
    pub power_w: Option<f64>,
}

/// Format and edition of a photometric file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhotometricFormat {
    /// LM-63-1986: free label lines.
    Ies1986,
    /// LM-63-1991.
    Ies1991,
    /// LM-63-1995.
    Ies1995,
    /// LM-63-2002.
    Ies2002,
    /// LM-63-2019.
    Ies2019,
    /// EULUMDAT.
    Eulumdat,
}

/// Which planes a file stores; the others are their mirror images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LateralSymmetry {
    /// One plane holds for all angles C.
    Rotational,
    /// Quarter: mirrored at C0–C180 and at C90–C270.
    Quadrant,
    /// Mirrored at the plane C0–C180.
    AboutC0,
    /// Mirrored at the plane C90–C270.
    AboutC90,
    /// All planes are stored.
    None,
}

/// Largest extent of a luminous opening in m: longer than any luminaire that is measured as one.
pub(in crate::scene) const LARGEST_OPENING_M: f64 = 100.0;

/// The luminous opening, in m; `c0` is the extent along C0–C180, `c90` along C90–C270.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opening {
    /// No extent.
    Point,
    /// A flat rectangle.
    Rectangle {
        /// Extent along C0–C180.
        c0_m: f64,
        /// Extent along C90–C270.
        c90_m: f64,
    },
    /// A box with luminous sides.
    Box {
        /// Extent along C0–C180.
        c0_m: f64,
        /// Extent along C90–C270.
        c90_m: f64,
        /// Extent along the axis.
        height_m: f64,
    },
    /// A flat disk.
    Disk {
        /// Diameter.
        diameter_m: f64,
    },
    /// A flat ellipse, or an elliptic cylinder about the axis if the height is not 0.
    Ellipse {
        /// Extent along C0–C180.
        c0_m: f64,
        /// Extent along C90–C270.
        c90_m: f64,
        /// Extent along the axis.
        height_m: f64,
    },
    /// A cylinder about the luminaire's axis.
    VerticalCylinder {
        /// Diameter.
        diameter_m: f64,
        /// Extent along the axis.
        height_m: f64,
    },
    /// A lying cylinder.
    HorizontalCylinder {
        /// Whether it lies along C0–C180; otherwise along C90–C270.
        along_c0: bool,
        /// Extent along its axis.
        length_m: f64,
        /// Extent across, in the plane.
        width_m: f64,
        /// Extent across, vertically.
        height_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Diameter.
        diameter_m: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Extent along C0–C180.
        c0_m: f64,
        /// Extent along C90–C270.
        c90_m: f64,
        /// Extent along the axis.
        height_m: f64,
    },
    /// An upright disk or ellipse, facing C0.
    UprightEllipse {
        /// Extent along C90–C270.
        width_m: f64,
        /// Extent along the axis.
        height_m: f64,
    },
}

impl Opening {
    /// Extents along C0–C180, C90–C270 and the axis in m.
    pub fn extents_m(&self) -> [f64; 3] {
        match *self {
            Opening::Point => [0.0; 3],
            Opening::Rectangle { c0_m, c90_m } => [c0_m, c90_m, 0.0],
            Opening::Disk { diameter_m } => [diameter_m, diameter_m, 0.0],
            Opening::Box { c0_m, c90_m, height_m }
            | Opening::Ellipse { c0_m, c90_m, height_m }
            | Opening::Ellipsoid { c0_m, c90_m, height_m } => [c0_m, c90_m, height_m],
            Opening::VerticalCylinder { diameter_m, height_m } => [diameter_m, diameter_m, height_m],
            Opening::HorizontalCylinder { along_c0: true, length_m, width_m, height_m } => {
                [length_m, width_m, height_m]
            }
            Opening::HorizontalCylinder { along_c0: false, length_m, width_m, height_m } => {
                [width_m, length_m, height_m]
            }
            Opening::Sphere { diameter_m } => [diameter_m; 3],
            Opening::UprightEllipse { width_m, height_m } => [0.0, width_m, height_m],
        }
    }
}

impl PhotometricFile {
    /// Luminous flux in lm: the integral of the intensities (exact for the bilinear interpolant).
    pub fn luminous_flux_lm(&self) -> f64 {
        self.web.luminous_flux_lm()
    }
}
