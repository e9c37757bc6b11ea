//! The name that programs look for at run time: `liberard.so.ABI`, whatever the file is called while it is built.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // ERARD_ABI of src/reading.rs; tests/abi/programs.rs compares.
    const ABI: u32 = 1;
    match std::env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux" | "freebsd") => println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,liberard.so.{ABI}"),
        Ok("macos") => println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/liberard.{ABI}.dylib"),
        _ => {}
    }
}
