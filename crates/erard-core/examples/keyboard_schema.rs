//! Prints the JSON Schema of keyboard files: `.ci/regenerate keyboard-schema`.

fn main() {
    print!("{}", erard_core::keyboard::json_schema());
}
