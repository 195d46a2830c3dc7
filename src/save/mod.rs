//! PIXELS OUT to files: snapshots (png, ppm, raw), depth as PFM, and the comparison of snapshots in tests.
