//! What a report says about where and how it was made.

use serde::{Deserialize, Serialize};

/// The provenance of a report.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Provenance {
    /// The program's version.
    pub version: String,
    /// The commit it was built from.
    pub commit: String,
    /// The processor.
    pub processor: String,
    /// Logical cores that the program saw.
    pub cores: usize,
    /// Threads that it used.
    pub threads: usize,
    /// Operating system and architecture.
    pub system: String,
    /// The command line, the program's own path left out.
    pub command: String,
    /// How long the whole measurement took.
    pub seconds: f64,
}

impl Provenance {
    /// Of this process, which began its work `seconds` ago.
    pub fn here(seconds: f64) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: env!("SIDESTEP_COMMIT").into(),
            processor: processor(),
            cores,
            threads: rayon::current_num_threads(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            command: format!("sidestep {}", arguments.join(" ")),
            seconds,
        }
    }
}

/// The processor's name where the system tells it.
fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find(|line| line.starts_with("model name"));
    name.and_then(|line| line.split(':').nth(1)).map_or("unknown".into(), |n| n.trim().to_string())
}
