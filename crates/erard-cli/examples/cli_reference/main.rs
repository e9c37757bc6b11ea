//! Prints the command-line reference: `cargo run --release -p erard-cli --example cli_reference > book/src/cli.md`.

mod page;

fn main() {
    print!("{}", page::markdown(erard_cli::command::definition()));
}
