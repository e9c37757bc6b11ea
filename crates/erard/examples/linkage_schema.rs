//! Prints the JSON Schema of linkage files: `cargo run -p erard --example linkage_schema > linkages/linkage.schema.json`.

fn main() {
    print!("{}", erard::kinematics::json_schema());
}
