//! Prints the JSON Schema of instrument files: `.ci/regenerate instrument-schema`.

fn main() {
    print!("{}", erard_core::instrument::json_schema());
}
