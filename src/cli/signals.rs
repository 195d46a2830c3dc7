//! SIGINT and SIGTERM: the first one ends a command in order, a second one at once.

/// Calls `end` at the first signal; a second one ends the process with status 130.
///
/// # Errors
/// If the system lets no handler be set: then a signal ends the process.
pub fn watch(mut end: impl FnMut() + Send + 'static) -> Result<(), String> {
    let mut has_come = false;
    ctrlc::set_handler(move || {
        if std::mem::replace(&mut has_come, true) {
            std::process::exit(130);
        }
        end();
    })
    .map_err(|e| format!("signals cannot be watched: {e}"))
}
