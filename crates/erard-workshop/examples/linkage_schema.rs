//! Prints the JSON Schema of linkage files: `cargo run -p erard-workshop --example linkage_schema >
//! linkages/linkage.schema.json`.

fn main() {
    print!("{}", erard_workshop::kinematics::json_schema());
}
