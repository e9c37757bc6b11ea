//! Prints the JSON Schema of instrument files: `cargo run -p erard --example schema >
//! instruments/instrument.schema.json`.

fn main() {
    print!("{}", erard::instrument::json_schema());
}
