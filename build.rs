//! Links the firmware anew when the memory layout changes; cargo does not see linker scripts by itself.

fn main() {
    println!("cargo:rerun-if-changed=memory.x");
}
