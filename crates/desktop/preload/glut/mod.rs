//! GLUT, for programs that show one picture: a memory of their own by `glDrawPixels` or on a
//! textured quad. Such a program needs no OpenGL, no X server and no graphics card.
//!
//! In: the calls of a program that was linked with `libglut`, `libGL` and `libGLU`, which the
//! loader finds here. Out: a mode of the device of the window's size, the picture in the device's
//! memory, and the callbacks of the program. The right answer is what a window of OpenGL 1.1 shows:
//! pixel (x, y) of the picture is the texel, or the element of `glDrawPixels`, that covers the
//! pixel's middle, without filters, light, or blending.
//!
//! Where an allocation of the program is what it shows, the device's memory is mapped in its place
//! ([`allocations`]): each store is seen at once, also by a debugger. Other memories are copied
//! when they are shown. What draws with OpenGL itself is told once for each function, and not
//! drawn.
//!
//! Built into the second variant of the preload library only (cfg `glut`); programs that are not
//! linked with GLUT get the first. GLUT and OpenGL belong to one thread, as they do elsewhere;
//! `malloc` and its kin may be called by all.

mod allocations;
mod blit;
mod calls;
mod ignored;
mod immediate;
mod input;
mod main_loop;
mod matrix;
mod screen;
mod state;
#[allow(dead_code)]
mod stores;
mod textures;
mod watch;
mod window;
