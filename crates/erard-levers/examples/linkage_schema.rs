//! Prints the JSON Schema of linkage files: `cargo run -p erard-levers --example linkage_schema >
//! linkages/linkage.schema.json`.

fn main() {
    print!("{}", erard_levers::json_schema());
}
