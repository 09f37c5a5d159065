//! Processor time: what others do on the machine meanwhile does not show in it.

use std::fs;

/// Ticks of the kernel's accounting a second (USER_HZ, the same on every Linux).
const TICKS: f64 = 100.0;

/// Processor time of this thread so far, s.
pub fn own_s() -> f64 {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ns = text.split_whitespace().next().and_then(|word| word.parse::<f64>().ok());
    ns.unwrap_or(f64::NAN) / 1e9
}

/// Processor time so far of the programs that were started and have ended, s; in hundredths.
pub fn children_s() -> f64 {
    let text = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name, which may hold anything: cutime and cstime are fields 16 and 17.
    let rest = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks = rest.split_whitespace().skip(13).take(2).flat_map(str::parse::<f64>);
    ticks.sum::<f64>() / TICKS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_shows() {
        let (own, children) = (own_s(), children_s());
        let mut sum = 0u64;
        while own_s() - own < 0.01 {
            sum = std::hint::black_box(sum + 1);
        }
        assert!(sum > 0);
        let words = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        let status = std::process::Command::new("sh").args(["-c", words]).status();
        assert!(status.is_ok_and(|status| status.success()));
        assert!(children_s() > children);
    }
}
