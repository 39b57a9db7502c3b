//! What measured: the processor as the system names it.

use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use super::model::Machine;
use super::player::Played;

pub fn machine(played: Option<&Played>) -> Machine {
    let asked = RefreshKind::nothing()
        .with_cpu(CpuRefreshKind::nothing())
        .with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(asked).ok();
    let processor = system.as_ref().and_then(|system| Some(system.cpus().first()?.brand().trim().to_owned()));
    let processor = processor.filter(|name| !name.is_empty());
    Machine {
        processor: processor.unwrap_or_else(|| "a processor without a name".to_owned()),
        threads: rayon::current_num_threads(),
        memory: system.as_ref().map_or(0, System::total_memory),
        system: System::long_os_version().unwrap_or_else(|_| std::env::consts::OS.to_owned()),
        adapter: played.map(|played| played.adapter.clone()),
        timing: played.map(|played| if played.on_gpu { "gpu" } else { "cpu" }.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_is_named() {
        let machine = machine(None);
        assert!(!machine.processor.is_empty() && !machine.system.is_empty());
        assert!(machine.threads > 0 && machine.memory > 1 << 20, "{machine:?}");
        assert_eq!(machine.adapter, None);
    }
}
