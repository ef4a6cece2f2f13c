//! A year of daylight: hourly illuminances by daylight coefficients, and the annual measures of standards.
//!
//! [`solve_year`] gathers the contribution of each sky patch, the ground and each hour's sun to every receiver. It does this once,
//! in sixteen replicas. Sums then give the hours. All errors follow from the halves into which the replicas can be divided.

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
