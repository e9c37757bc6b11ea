//! Prints the JSON Schema of keyboard files: `cargo run -p erard --example keyboard_schema >
//! keyboards/keyboard.schema.json`.

fn main() {
    print!("{}", erard::keyboard::json_schema());
}
