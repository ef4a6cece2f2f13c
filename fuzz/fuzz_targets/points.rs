//! Any text as a points file.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxmc::scene::receiver_points_from_csv;

fuzz_target!(|text: &str| match receiver_points_from_csv(text, Path::new("probes.csv")) {
    Ok(points) => {
        for point in points {
            assert!((point.normal.length() - 1.0).abs() < 1e-9 && point.position_m.is_finite());
            assert!(point.weight > 0.0);
        }
    }
    Err(error) => {
        std::hint::black_box(error.to_string());
    }
});
