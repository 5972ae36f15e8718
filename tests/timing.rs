//! Seconds that trials take, by part: what a suite's time goes into has names.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Parts and trials that are listed at the end.
const LISTED: usize = 12;

static TAKEN: Mutex<Vec<(String, f64)>> = Mutex::new(Vec::new());

/// Runs the body of a trial and keeps how long it took.
pub fn timed<T>(name: &str, body: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let result = body();
    let taken = (name.to_owned(), began.elapsed().as_secs_f64());
    TAKEN
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(taken);
    result
}

/// Prints the parts and the trials that took longest. Trials run side by side, so their sum is more than the time that passed.
pub fn tell() {
    let taken = std::mem::take(&mut *TAKEN.lock().unwrap_or_else(PoisonError::into_inner));
    if taken.len() < 2 {
        return;
    }
    let mut parts: BTreeMap<&str, f64> = BTreeMap::new();
    for (name, seconds) in &taken {
        *parts
            .entry(name.split("::").next().unwrap_or(name))
            .or_default() += seconds;
    }
    list("parts", parts.into_iter());
    list("trials", taken.iter().map(|(name, s)| (name.as_str(), *s)));
}

fn list<'a>(what: &str, all: impl Iterator<Item = (&'a str, f64)>) {
    let mut all: Vec<_> = all.collect();
    let sum: f64 = all.iter().map(|(_, seconds)| seconds).sum();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    println!("longest {what}, of {} with {sum:.0} s:", all.len());
    for (name, seconds) in all.iter().take(LISTED) {
        println!("{seconds:8.1} s  {name}");
    }
}
