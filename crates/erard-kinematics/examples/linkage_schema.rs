//! Prints the JSON Schema of linkage files: `cargo run -p erard-kinematics --example linkage_schema >
//! linkages/linkage.schema.json`.

fn main() {
    print!("{}", erard_kinematics::json_schema());
}
