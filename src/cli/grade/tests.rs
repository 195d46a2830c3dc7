//! Sheets and their errors.
