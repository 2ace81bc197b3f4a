//! The `whitefurnace` program: see [`whitefurnace::cli`].
fn main() -> std::process::ExitCode {
    whitefurnace::cli::main()
}
