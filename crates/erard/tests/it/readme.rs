//! The project's README shows an example that is tested: the one of this crate's README, which is a documentation test.

/// The first Rust block of a text, without the lines that rustdoc hides.
fn first_rust_block(text: &str) -> Vec<&str> {
    let block = text.split("```rust\n").nth(1).and_then(|after| after.split("```").next()).expect("a Rust block");
    block.lines().filter(|line| !line.starts_with("# ")).collect()
}

#[test]
fn the_project_s_readme_shows_the_example_of_this_crate() {
    let project = first_rust_block(include_str!("../../../../README.md"));
    assert_eq!(project, first_rust_block(include_str!("../../README.md")));
    assert!(project.len() > 5);
}
