//! The emulated framebuffer device of `fbptr run`: the program's side of it.
//!
//! In: what programs write into the device's memory and its control page, through the preload
//! library (`preload/`), which runs in their processes. Out: rows of video memory, on the render
//! thread; vertical blanks; input events as the kernel's devices give them. Promises: whatever a
//! program writes into the shared memories, nothing here panics or reads outside of them; nothing
//! is left of the device when this process has ended, however it ended. Tested by
//! `tests/serving/run/` with real programs.

#[path = "../../preload/attributes.rs"]
mod attributes;
mod device;
#[path = "../../preload/elf.rs"]
pub mod elf;
mod input;
#[path = "../../preload/keys.rs"]
pub mod keys;
// The preload library uses the rest of them.
#[path = "../../preload/layout.rs"]
#[allow(dead_code)]
mod layout;
#[path = "../../preload/mode.rs"]
#[allow(dead_code)]
mod mode;
mod scanout;
#[cfg(test)]
#[path = "../../preload/glut/stores.rs"]
mod stores;
mod sysfs;

pub use device::{Device, DeviceOptions, preload_library};
pub use input::{InputDevices, typing};
pub use layout::{ENVIRONMENT, OPENS_AT, TERMINALS};
pub use mode::{FORMATS, Format};
pub use scanout::ScanOut;

#[cfg(test)]
mod tests {
    use super::stores::size_of_store;

    #[test]
    fn the_bytes_that_an_instruction_stores_are_those_of_the_manual() {
        // What an assembler makes of the instructions that compilers store pixels by.
        let code: [(&[u8], usize, &str); 22] = [
            (&[0xc6, 0x00, 0x07], 1, "movb $7, (%rax)"),
            (&[0x88, 0x14, 0x08], 1, "mov %dl, (%rax,%rcx)"),
            (&[0x40, 0x88, 0x30], 1, "mov %sil, (%rax)"),
            (&[0x66, 0xc7, 0x00, 1, 2], 2, "movw"),
            (&[0x89, 0x08], 4, "mov %ecx, (%rax)"),
            (&[0x44, 0x89, 0x00], 4, "mov %r8d, (%rax)"),
            (&[0xc7, 0x00, 1, 2, 3, 4], 4, "movl"),
            (&[0x48, 0x89, 0x08], 8, "mov %rcx, (%rax)"),
            (&[0xf3, 0xaa], 1, "rep stosb"),
            (&[0xf3, 0x48, 0xab], 8, "rep stosq"),
            (&[0x01, 0x08], 4, "add %ecx, (%rax)"),
            (&[0x80, 0x00, 1], 1, "addb"),
            (&[0x0f, 0x11, 0x00], 16, "movups"),
            (&[0x66, 0x0f, 0x7f, 0x00], 16, "movdqa"),
            (&[0xf3, 0x0f, 0x11, 0x00], 4, "movss"),
            (&[0xf2, 0x0f, 0x11, 0x00], 8, "movsd"),
            (&[0x66, 0x0f, 0xd6, 0x00], 8, "movq %xmm0, (%rax)"),
            (&[0x66, 0x0f, 0x7e, 0x00], 4, "movd"),
            (&[0xc5, 0xfa, 0x7f, 0x00], 16, "vmovdqu %xmm0"),
            (&[0xc5, 0xfe, 0x7f, 0x00], 32, "vmovdqu %ymm0"),
            (&[0xc4, 0xc1, 0x7e, 0x7f, 0x00], 32, "vmovdqu %ymm0, (%r8)"),
            (&[0x62, 0xf1, 0xfe, 0x48, 0x7f, 0x00], 64, "vmovdqu64 %zmm0"),
        ];
        for (bytes, size, name) in code {
            assert_eq!(size_of_store(bytes), size, "{name}");
        }
        // Whatever else is there counts as something.
        for byte in 0..=255 {
            for code in [&[byte][..], &[0x0f, byte], &[0x66, 0x0f, byte], &[0x62, 0, byte, byte, byte]] {
                assert!((1..=64).contains(&size_of_store(code)));
            }
        }
        assert_eq!(size_of_store(&[]), 1);
    }
}
