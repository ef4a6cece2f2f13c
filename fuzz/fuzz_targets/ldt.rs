//! Any bytes as an EULUMDAT file: read, and evaluated for fluxes and intensities if it is valid.
#![no_main]

use libfuzzer_sys::fuzz_target;
use luxmc::scene::photometry::parse_eulumdat;

fuzz_target!(|bytes: &[u8]| match parse_eulumdat(bytes) {
    Ok(file) => {
        assert!(file.luminous_flux_lm() >= 0.0);
        for (c_deg, gamma_deg) in [(0.0, 0.0), (45.0, 30.0), (359.9, 179.9), (-720.5, 90.0), (1e300, 200.0)] {
            assert!(file.web.intensity_cd(c_deg, gamma_deg) >= 0.0);
        }
        std::hint::black_box((file.web.hemisphere_fluxes_lm(), file.opening.extents_m()));
    }
    Err(error) => {
        std::hint::black_box(error.to_string());
    }
});
