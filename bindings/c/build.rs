//! The name that programs look for at run time: `liberard.so.ABI`, whatever the file is called while it is built; of
//! the library for control loops, which has no workshop, `liberard-rt.so.ABI`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // ERARD_ABI of src/reading.rs; tests/abi/programs.rs compares.
    const ABI: u32 = 1;
    let name = if std::env::var_os("CARGO_FEATURE_WORKSHOP").is_some() { "erard" } else { "erard-rt" };
    match std::env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux" | "freebsd") => println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,lib{name}.so.{ABI}"),
        Ok("macos") => println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/lib{name}.{ABI}.dylib"),
        _ => {}
    }
}
