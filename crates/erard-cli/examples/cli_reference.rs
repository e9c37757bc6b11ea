//! Prints the command-line reference: `cargo run --release -p erard-cli --example cli_reference > book/src/cli.md`.

fn main() {
    print!("{}", erard_cli::cli_reference::markdown());
}
