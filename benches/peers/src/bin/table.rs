//! Joins all rows into one table: `table ROWS.jsonl TRUTH_DIR SHOTS_DIR OUT_DIR` writes
//! OUT_DIR/peers.md and peers.json.
//!
//! A row's time is the median of its best round. Pixels off are those with a channel more than
//! 1/255 from the truth's picture; fbptr's own rows carry theirs. The ratio is the peer's time over
//! fbptr's with as many threads.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Returns the R, G, B bytes of a PPM as the peers write it.
fn picture(path: &Path) -> Option<Vec<u8>> {
    let bytes = fs::read(path).ok()?;
    let mut at = 0;
    // P6, width, height, 255: four words, each followed by one blank.
    for _ in 0..4 {
        at += bytes[at..].iter().position(u8::is_ascii_whitespace)? + 1;
    }
    Some(bytes[at..].to_vec())
}

/// Returns the number of pixels off by more than a step, and the largest difference.
fn pixels_off(found: &[u8], truth: &[u8]) -> Option<(u64, u64)> {
    if found.len() != truth.len() {
        return None;
    }
    let worst = found.chunks_exact(3).zip(truth.chunks_exact(3));
    let worst = worst.map(|(a, b)| a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).max().unwrap_or(0));
    Some(worst.fold((0, 0), |(off, max), w| (off + u64::from(w > 1), max.max(w))))
}

fn threads(cfg: &str) -> &str {
    cfg.split('T').next().unwrap_or(cfg)
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [rows, truths, shots, out] = args.as_slice() else {
        eprintln!("usage: table ROWS.jsonl TRUTH_DIR SHOTS_DIR OUT_DIR");
        std::process::exit(2);
    };
    let text = fs::read_to_string(rows).unwrap_or_else(|e| panic!("{rows}: {e}"));
    let mut best: BTreeMap<(String, String, String), Value> = BTreeMap::new();
    for row in text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
        let word = |name: &str| row[name].as_str().unwrap_or("?").to_owned();
        let mut cfg = word("cfg");
        // fbptr's rows of other vector levels are rows of their own.
        if let Some(simd) = row["simd"].as_str().filter(|s| *s != "none") {
            cfg = format!("{cfg} {simd}");
        }
        let old = best.entry((word("wl"), word("peer"), cfg)).or_insert_with(|| row.clone());
        if row["med_ms"].as_f64() < old["med_ms"].as_f64() {
            *old = row;
        }
    }
    let ours = |workload: &str, cfg: &str| {
        let same = best.iter().filter(|((wl, peer, c), _)| {
            wl == workload && peer == "fbptr" && (threads(c) == threads(cfg) || workload.starts_with("W7"))
        });
        same.filter_map(|(_, row)| row["med_ms"].as_f64()).min_by(f64::total_cmp)
    };
    let mut markdown = String::from(
        "| workload | program | threads | median ms | times fbptr's | pixels off | largest error |\n|---|---|---|---|---|---|---|\n",
    );
    let mut all = Vec::new();
    for ((workload, peer, cfg), row) in &best {
        let median = row["med_ms"].as_f64().unwrap_or(f64::NAN);
        let ratio = ours(workload, cfg).map(|own| median / own);
        let error = match row["pixels_off"].as_u64() {
            Some(off) => Some((off, row["max_err"].as_u64().unwrap_or(0))),
            None => {
                let shot = row["cfg"].as_str().unwrap_or("?");
                let found = picture(&Path::new(shots).join(format!("{peer}_{shot}_{workload}.ppm")));
                let truth = picture(&Path::new(truths).join(format!("{workload}.ppm")));
                found.zip(truth).and_then(|(found, truth)| pixels_off(&found, &truth))
            }
        };
        let text = |v: Option<String>| v.unwrap_or_else(|| "-".into());
        writeln!(
            markdown,
            "| {workload} | {peer} | {cfg} | {median:.2} | {} | {} | {} |",
            text(ratio.map(|r| format!("{r:.2}"))),
            text(error.map(|e| e.0.to_string())),
            text(error.map(|e| format!("{}/255", e.1))),
        )
        .expect("a String takes all text");
        all.push(json!({
            "wl": workload, "peer": peer, "cfg": cfg, "med_ms": median, "min_ms": row["min_ms"],
            "times_fbptr": ratio, "pixels_off": error.map(|e| e.0), "max_err": error.map(|e| e.1),
        }));
    }
    print!("{markdown}");
    let save = |name: &str, text: &str| {
        let path = Path::new(out).join(name);
        fs::write(&path, text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    };
    save("peers.md", &markdown);
    save("peers.json", &format!("{:#}\n", Value::from(all)));
}
