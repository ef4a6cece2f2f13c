//! A year of daylight: hourly illuminances by daylight coefficients, and what standards count in them.
//!
//! [`solve_year`] gathers for every receiver what each patch of the sky, the ground and each hour's sun bring it, once, in sixteen replicas; the hours
//! follow by sums, and all errors by the halves into which the replicas can be parted.

mod count;
mod exposure;
mod hours;
mod receiver;
mod result;
mod run;
mod sun_cells;
mod sun_nodes;
mod survey;

pub use count::{
    ASE_HOURS, ASE_LX, ASE_SHARE, AUTONOMY_LX, BLINDS_SHARE, MEASURES, SDA_SHARE, UDI_LIMITS_LX, YearMeasure,
};
pub use exposure::{EXPOSURE_HOURS, SetSunlight, SunSite, SunlitHours, sum_of_hours, sunlight};
pub use hours::{YearHour, YearSky};
pub use result::{SetYear, YearPoint, YearSolution};
pub use run::{Blinds, NotForYear, YearHours, YearSettings, solve_year};
