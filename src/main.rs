//! The `luxmc` program. All of its code is in the library's `cli` room.

#[global_allocator]
static MEMORY: luxmc::base::memory::CountedMemory = luxmc::base::memory::CountedMemory;

fn main() -> std::process::ExitCode {
    luxmc::cli::run()
}
