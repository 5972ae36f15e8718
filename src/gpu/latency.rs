//! What asking a device costs, whatever it computes: a dispatch, a pass, a submission, a write, a wait, a map.
//!
//! A step of a small canopy is bounded by these, not by bandwidth or arithmetic.

/// Latencies of a device \[s\].
#[derive(Debug, Clone, PartialEq)]
pub struct Latencies {
    /// One more empty dispatch in a pass.
    pub dispatch_s: f64,
    /// The same by the device's clock; `None` where it has none.
    pub dispatch_on_device_s: Option<f64>,
    /// One more pass with an empty dispatch in a submission.
    pub pass_s: f64,
    /// The host records and submits an empty dispatch, and does not wait.
    pub submit_s: f64,
    /// The host writes 64 bytes to a buffer.
    pub write_s: f64,
    /// An empty dispatch is submitted, and the host sleeps until it is done.
    pub wait_s: f64,
    /// The same, but the host asks again and again.
    pub spin_s: f64,
    /// As `wait_s`, and 16 bytes are mapped and read.
    pub map_s: f64,
    /// The same, but the host asks again and again.
    pub map_spin_s: f64,
}

impl Latencies {
    /// Name, value \[s\] and meaning of every latency.
    #[must_use]
    pub fn rows(&self) -> Vec<(&'static str, f64, &'static str)> {
        let mut rows = vec![(
            "dispatch",
            self.dispatch_s,
            "one more empty dispatch in a pass",
        )];
        if let Some(seconds) = self.dispatch_on_device_s {
            rows.push((
                "dispatch on device",
                seconds,
                "the same by the device's clock, which waits for the one before",
            ));
        }
        rows.extend([
            ("pass", self.pass_s, "one more pass with an empty dispatch"),
            (
                "submit",
                self.submit_s,
                "record and submit, without waiting",
            ),
            ("write", self.write_s, "64 bytes to a buffer"),
            ("wait", self.wait_s, "submit, and sleep until it is done"),
            ("spin", self.spin_s, "submit, and ask until it is done"),
            ("map", self.map_s, "submit, sleep, map and read 16 bytes"),
            (
                "map spinning",
                self.map_spin_s,
                "submit, ask, map and read 16 bytes",
            ),
        ]);
        rows
    }
}
