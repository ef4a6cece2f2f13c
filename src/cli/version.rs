//! `luxmc --version`: version, commit, target, and features of the processor.

use std::sync::LazyLock;

/// Names of the processor's features among those that the program was built for or uses.
fn features() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let known = [
        ("sse2", std::arch::is_x86_feature_detected!("sse2")),
        ("sse4.2", std::arch::is_x86_feature_detected!("sse4.2")),
        ("avx", std::arch::is_x86_feature_detected!("avx")),
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(target_arch = "aarch64")]
    let known = [("neon", std::arch::is_aarch64_feature_detected!("neon"))];
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let known: [(&str, bool); 0] = [];
    known.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect()
}

/// Names of the features that the program was built to need, beyond the basic set of the target.
fn needed() -> Vec<&'static str> {
    [
        ("avx", cfg!(target_feature = "avx")),
        ("fma", cfg!(target_feature = "fma")),
        ("avx2", cfg!(target_feature = "avx2")),
    ]
    .into_iter()
    .filter(|(_, is_needed)| *is_needed)
    .map(|(name, _)| name)
    .collect()
}

fn or_none(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(" ") }
}

/// The text after the program's name.
pub fn long_version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let commit = match env!("LUXMC_BUILT_FROM") {
            "" => "not known (built without git, or from a tree without it)",
            commit => commit,
        };
        format!(
            "{}\ncommit:    {commit}\ntarget:    {}\nprocessor: {} (needed beyond the target: {})",
            env!("CARGO_PKG_VERSION"),
            env!("LUXMC_BUILT_FOR"),
            or_none(&features()),
            or_none(&needed())
        )
    });
    &TEXT
}
