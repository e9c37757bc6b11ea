//! What became of a stream, in words and as JSON.

use erard_live::Report;
use serde_json::{Value, json};

use super::latency::{LATE_S, Latency};
use crate::failure::Failure;
use crate::table::Table;

/// All that is reported of a stream.
pub(crate) struct StreamSummary {
    pub stream: String,
    pub keyboard: String,
    pub report: Report,
    /// Lines that were no samples, and the first one's number and fault.
    pub malformed: u64,
    pub first_malformed: Option<(u64, String)>,
    /// `None` for a file, whose lines come whenever they are asked for.
    pub latency: Option<Latency>,
}

impl StreamSummary {
    pub(crate) fn json(&self) -> Result<Value, Failure> {
        let first = self.first_malformed.as_ref().map(|(line, what)| json!({"line": line, "what": what}));
        let mut all = json!({
            "stream": self.stream,
            "keyboard": self.keyboard,
            "malformed_lines": self.malformed,
            "first_malformed": first,
            "latency": self.latency,
        });
        if let (Some(all), Value::Object(report)) = (all.as_object_mut(), serde_json::to_value(&self.report)?) {
            all.extend(report);
        }
        Ok(all)
    }

    pub(crate) fn text(&self) -> Vec<String> {
        let r = &self.report;
        let mut lines = vec![
            format!("{} on {} - {:.1} s, {} samples", self.stream, self.keyboard, r.duration_s, r.samples),
            format!("  {} note-ons, {} note-offs", r.note_ons, r.note_offs),
        ];
        let mut counted = |count: u64, what: &str| {
            if count > 0 {
                lines.push(format!("  {count} {what}"));
            }
        };
        counted(r.lifts, "rises of hammers that turned before their stops: no notes");
        counted(r.bounces, "changes of contacts that were bounces");
        counted(r.untimed_strokes, "strokes without a note: no upper contact had opened and closed again");
        counted(r.slow_strokes, "strokes too slow to throw a hammer to its string");
        counted(r.swapped_contacts, "contacts that closed after the one below them");
        counted(r.fast_strokes, "strokes faster than any press: do both contacts close at once? Sent as the fastest");
        counted(r.limited_strokes, "strokes limited, whose hammers would have been faster than 8 m/s");
        counted(r.deep_samples, "samples deeper than the key goes");
        counted(r.out_of_order, "samples skipped: not later than their key's last one");
        counted(r.dropped_stamps, "samples skipped: stamps more than 1 s from their neighbours'");
        counted(r.stream_gaps, "gaps of more than 1 s in the whole stream: held notes ended");
        counted(r.new_clocks, "new clocks, a header or stamps that go back: held notes ended");
        counted(r.unseen_releases, "note-offs whose release was not seen: sent as 64");
        counted(r.uncalibrated, "samples skipped: their keys or contacts are not in the calibration");
        counted(r.gaps, "gaps of 0.1 s or more while the key was off its rest");
        counted(r.stalls, "stalls: all keys were let go");
        counted(r.drifts_beyond, "drifts beyond 15 % of a sensor's range");
        counted(r.non_finite_steps, "steps in which a number was not finite");
        counted(r.false_announcements, "announced impacts that did not come: ended at once");
        if let Some(why) = &r.silence {
            lines.push(format!("  no notes: {why}"));
        }
        if let Some((line, what)) = &self.first_malformed {
            lines.push(format!("  {} lines left out; the first, line {line}: {what}", self.malformed));
        }
        for (keys, what) in [(&r.stuck_keys, "stuck"), (&r.noisy_keys, "noisy")] {
            if !keys.is_empty() {
                let keys = keys.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
                lines.push(format!("  sensors that may be {what}: keys {keys}"));
            }
        }
        if let Some(latency) = self.latency.as_ref().filter(|latency| latency.notes > 0) {
            lines.push(format!(
                "  handed over after the impact: {:.2} ms (half), {:.2} ms (99.9 %), {:.2} ms (longest); {} of {} \
                 later than {} ms",
                latency.p50_ms,
                latency.p999_ms,
                latency.longest_ms,
                latency.late,
                latency.notes,
                1e3 * LATE_S
            ));
        }
        if r.longest_on_a_cable_s > 0.0 {
            lines.push(format!("  on a DIN cable a message would wait up to {:.1} ms", 1e3 * r.longest_on_a_cable_s));
        }
        if !r.ahead.is_empty() {
            let heads = ["level", "notes", "announced", "lead, ms", "at least", "error, ms", "of speed, %", ""];
            let rows = r.ahead.iter().map(|lead| {
                vec![
                    lead.level.to_owned(),
                    lead.notes.to_string(),
                    lead.announced.to_string(),
                    format!("{:.2}", lead.median_ms),
                    format!("{:.2}", lead.shortest_ms),
                    format!("{:.3}", lead.largest_error_ms),
                    format!("{:.2}", 100.0 * lead.largest_error_of_speed),
                    if lead.useless { "useless: below 1 ms" } else { "" }.to_owned(),
                ]
            });
            lines.push(String::new());
            lines.extend(Table::of(heads, rows.collect::<Vec<_>>()).lines());
        }
        lines
    }

    /// What speaks against the sensor.
    pub(crate) fn warning(&self) -> Option<String> {
        use erard_live::quality::{FEWEST_BITS, LOWEST_HZ};
        let (bits, rate, error) = (self.report.bits?, self.report.rate_hz?, self.report.expected_error_counts?);
        // Half a bit, and a hundredth: what is seen of a sensor of just so much.
        (bits < FEWEST_BITS - 0.5 || rate < 0.99 * LOWEST_HZ).then(|| {
            format!(
                "warning: the sensor has {bits:.1} bits and {rate:.0} Hz; expected {FEWEST_BITS} bits and {LOWEST_HZ} \
                 Hz. The expected error of speed is {error:.1} counts of velocity ({:.0} %)",
                100.0 * (2.0_f64.powf(error / 25.0) - 1.0)
            )
        })
    }
}
