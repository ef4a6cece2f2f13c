//! The upper end of a colour scale that many surfaces share.

/// Share of the area that lies below the end of the scale. The rest, luminaires and their surroundings, may exceed it.
pub const SHARE_IN_SCALE: f64 = 0.98;

/// The illuminance in lx below which nearly all of the area lies, rounded up to two digits. `lit` has illuminances in lx and their
/// areas in m². `None` if everything is dark.
pub fn end_of_scale_lx(mut lit: Vec<(f64, f64)>) -> Option<f64> {
    lit.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted_m2 = SHARE_IN_SCALE * lit.iter().map(|(_, area_m2)| area_m2).sum::<f64>();
    let mut below_m2 = 0.0;
    let end = lit.iter().find(|(_, area_m2)| {
        below_m2 += area_m2;
        below_m2 >= wanted_m2
    });
    let end_lx = end.or(lit.last()).map(|(lx, _)| *lx).filter(|lx| *lx > 0.0)?;
    let step = 10f64.powf(end_lx.log10().floor() - 1.0);
    Some((end_lx / step).ceil() * step)
}

#[cfg(test)]
mod tests {
    use super::end_of_scale_lx;

    #[test]
    fn what_is_small_and_bright_does_not_stretch_the_scale() {
        assert_eq!(end_of_scale_lx(vec![(9_000.0, 0.1), (431.0, 5.0), (120.0, 5.0)]), Some(440.0));
        assert_eq!(end_of_scale_lx(vec![(0.0, 5.0), (9_000.0, 0.05)]), None);
        assert_eq!(end_of_scale_lx(Vec::new()), None);
    }
}
