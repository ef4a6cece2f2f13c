//! Reads `energy`: hours of use and factors of the installed power that the energy of a year follows from, as far as the user gives them.

use super::error::SceneError;
use super::keys::{ABOVE_ZERO, FROM_ZERO, Form, SHARE, ValueShape, form, from_to, optional};
use super::reader::Node;

/// Data for LENI besides the luminaires' power; see docs/methods.md, section 25.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Hours of use in a year by daylight.
    pub day_hours: f64,
    /// Hours of use in a year without daylight.
    pub night_hours: f64,
    /// F_C: share of the power that remains with control for constant illuminance, mean over the years.
    pub constant_illuminance_factor: f64,
    /// F_O: share of the hours that remains with control by presence.
    pub occupancy_factor: f64,
    /// F_D: share of the hours by day that remains with control by daylight.
    pub daylight_factor: f64,
    /// Energy for controls on standby and for charging batteries in a year, in kWh per m².
    pub standby_kwh_m2: f64,
    /// Area in m² that LENI refers to; `None`: the floor's.
    pub area_m2: Option<f64>,
}

/// Hours of a year, up to those of a leap year.
const YEAR_HOURS: ValueShape = from_to(0.0, 8784.0);

/// Keys of `energy`.
#[rustfmt::skip]
pub(super) const FORM: Form = form("Energy", "Data for LENI besides the power of the luminaires.", &[&[
    optional("day_hours", YEAR_HOURS, "Hours of use per year during daylight; 2250, typical of offices, by default."),
    optional("night_hours", YEAR_HOURS, "Hours of use per year without daylight; 250, typical of offices, by default."),
    optional("constant_illuminance_factor", SHARE, "Share of the power that remains with control for constant illuminance; 1 by default."),
    optional("occupancy_factor", SHARE, "Share of the hours that remains with control by presence; 1 by default."),
    optional("daylight_factor", SHARE, "Share of the daylight hours that remains with control by daylight; 1 by default."),
    optional("standby_kwh_m2", FROM_ZERO, "Yearly energy of controls on standby and of battery charging in kWh per m²; 0 by default."),
    optional("area_m2", ABOVE_ZERO, "Reference area in m²; the floor's by default."),
]]);

impl Default for Energy {
    /// Hours that are typical of offices, without savings by controls and without standby.
    fn default() -> Energy {
        Energy {
            day_hours: 2250.0,
            night_hours: 250.0,
            constant_illuminance_factor: 1.0,
            occupancy_factor: 1.0,
            daylight_factor: 1.0,
            standby_kwh_m2: 0.0,
            area_m2: None,
        }
    }
}

impl Energy {
    /// LENI in kWh per year and m², by the quick method of EN 15193. The installed power is in W, the area in m².
    ///
    /// Source: docs/methods.md (30).
    pub fn leni_kwh_m2(&self, installed_w: f64, area_m2: f64) -> f64 {
        let hours = self.day_hours * self.daylight_factor + self.night_hours;
        let lighting_kwh = installed_w * self.constant_illuminance_factor * self.occupancy_factor * hours / 1000.0;
        lighting_kwh / area_m2 + self.standby_kwh_m2 // (30)
    }
}

pub(super) fn read(node: &Node) -> Result<Energy, SceneError> {
    let fields = node.object("the data for the energy of lighting", &FORM)?;
    let usual = Energy::default();
    let hours = |key: &str, usual: f64| match fields.get(key) {
        None => Ok(usual),
        Some(node) => {
            let (hours, most) = (node.amount("the hours of use in a year")?, node.range().most);
            if hours > most {
                let what = format!("a year has no more than {most} hours");
                return Err(node.refuse(what, format!("0 to {most}"), "write 2250, for example"));
            }
            Ok(hours)
        }
    };
    let factor = |key: &str, what: &str| fields.get(key).map_or(Ok(1.0), |node| node.amount(what));
    Ok(Energy {
        day_hours: hours("day_hours", usual.day_hours)?,
        night_hours: hours("night_hours", usual.night_hours)?,
        constant_illuminance_factor: factor("constant_illuminance_factor", "the factor of constant illuminance")?,
        occupancy_factor: factor("occupancy_factor", "the factor of occupancy")?,
        daylight_factor: factor("daylight_factor", "the factor of daylight")?,
        standby_kwh_m2: fields.get("standby_kwh_m2").map_or(Ok(0.0), |node| node.amount("the energy on standby"))?,
        area_m2: fields.get("area_m2").map(|node| node.amount("the area")).transpose()?,
    })
}

#[cfg(test)]
mod tests {
    use super::Energy;

    /// By hand: 500 W for (2000·0.7 + 500)·0.9·0.8 h are 684 kWh. On 40 m² this is 17.1 kWh/m², and standby adds 1.5.
    #[test]
    fn leni_is_what_is_worked_out_by_hand() {
        let energy = Energy {
            day_hours: 2000.0,
            night_hours: 500.0,
            constant_illuminance_factor: 0.9,
            occupancy_factor: 0.8,
            daylight_factor: 0.7,
            standby_kwh_m2: 1.5,
            area_m2: None,
        };
        assert!((energy.leni_kwh_m2(500.0, 40.0) - 18.6).abs() < 1e-12);
        assert!((Energy::default().leni_kwh_m2(400.0, 40.0) - 25.0).abs() < 1e-12);
    }
}
