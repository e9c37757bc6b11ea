//! Prints the JSON Schema of linkage files: `.ci/regenerate linkage-schema`.

fn main() {
    print!("{}", erard_kinematics::json_schema());
}
