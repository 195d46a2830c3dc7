//! Drawing in two dimensions: pixels, lines, areas, circles, text, blits.
//!
//! In: numbers in pixels. Out: bytes in a `VideoMemory`. Outlines address pixels by whole numbers; fills cover area in real
//! coordinates, where pixel (i,j) is the square [i,i+1)x[j,j+1). What leaves the frame is clipped silently, at the cost of
//! the visible part.
