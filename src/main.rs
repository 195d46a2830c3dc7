//! The `fbptr` program: arguments, start, stop. It draws nothing and parses no bytes.

fn main() -> std::process::ExitCode {
    fbptr::cli::main()
}
