//! Prints the command-line reference: `.ci/regenerate cli`.

mod page;

fn main() {
    print!("{}", page::markdown(erard_cli::command::definition()));
}
