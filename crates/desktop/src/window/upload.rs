//! Upload of the window's words to the screen.
//!
//! minifb copies the whole window and sends it through the X server's socket, 33 MB at 3840x2160,
//! for each frame. Here only the rows that changed are written, to a memory file that the server
//! has mapped (MIT-SHM 1.2), from which it copies them. Without X, with a server on another machine
//! or without that extension, and for windows of other pixels than 0x00RRGGBB in words of the
//! machine's byte order, minifb uploads as before.
//!
//! In: the window's words and the rows of them that changed since the last upload. Out: the same
//! picture on the screen as minifb's. The server copies while the next frame is made; rows are not
//! written before it has finished. What it reports as exposed is uploaded again. Runs on the main thread.

use super::x_window::{Error, XWindow};
use rustix::fs::{MemfdFlags, memfd_create};
use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::Event;
use x11rb::protocol::shm::{self, ConnectionExt as _, Seg};
use x11rb::protocol::xproto::{
    ChangeWindowAttributesAux, ConnectionExt as _, CreateGCAux, EventMask, Gcontext, ImageFormat, ImageOrder,
    Window,
};
use x11rb::rust_connection::RustConnection;

/// Uploads to one window.
pub(super) struct Upload(Option<SharedUpload>);

impl Upload {
    /// Prepares uploads to `window`.
    pub fn new(window: &minifb::Window) -> Upload {
        Upload(SharedUpload::new(window).ok())
    }

    /// Shows `words`, the window of `size` pixels, of which `rows` changed since the last call.
    /// Returns whether they are on the screen; if not, the next call must have all words. The window
    /// may be gone then, so minifb, for which that ends the process, is left alone.
    pub fn show(
        &mut self,
        window: &mut minifb::Window,
        words: &[u32],
        size: [usize; 2],
        rows: Range<usize>,
    ) -> bool {
        if let Some(shared) = &mut self.0 {
            let is_shown = shared.show(words, size, rows).is_ok();
            match is_shown {
                true => window.update(),
                false => self.0 = None,
            }
            return is_shown;
        }
        window.update_with_buffer(words, size[0], size[1]).is_ok()
    }

    /// Handles the window's events, and shows again what the server has lost.
    pub fn idle(&mut self, window: &mut minifb::Window) {
        window.update();
        if let Some(shared) = &mut self.0
            && shared.restore().is_err()
        {
            self.0 = None;
        }
    }
}

/// Upload through memory that the X server has mapped.
struct SharedUpload {
    connection: RustConnection,
    window: Window,
    context: Gcontext,
    depth: u8,
    pixels: Option<SharedPixels>,
    /// Set while the server may be copying.
    is_copying: bool,
}

/// Memory file with the pixels of a window of this size.
struct SharedPixels {
    file: File,
    segment: Seg,
    size: [u16; 2],
}

impl SharedUpload {
    fn new(window: &minifb::Window) -> Result<SharedUpload, Error> {
        let XWindow { connection, window, .. } = XWindow::of(window)?;
        connection.extension_information(shm::X11_EXTENSION_NAME)?.ok_or("no MIT-SHM")?;
        let version = connection.shm_query_version()?.reply()?;
        if (version.major_version, version.minor_version) < (1, 2) {
            return Err("a MIT-SHM without memory files".into());
        }
        let depth = connection.get_geometry(window)?.reply()?.depth;
        let visual = connection.get_window_attributes(window)?.reply()?.visual;
        if !has_plain_words(&connection, depth, visual) {
            return Err("other pixels".into());
        }
        let wanted = ChangeWindowAttributesAux::new().event_mask(EventMask::EXPOSURE);
        connection.change_window_attributes(window, &wanted)?.check()?;
        let context = connection.generate_id()?;
        // Without events about each copy.
        connection.create_gc(context, window, &CreateGCAux::new().graphics_exposures(0))?.check()?;
        Ok(SharedUpload { connection, window, context, depth, pixels: None, is_copying: false })
    }

    /// Writes the changed rows, and has the server copy them.
    fn show(&mut self, words: &[u32], size: [usize; 2], rows: Range<usize>) -> Result<(), Error> {
        let size = [u16::try_from(size[0])?, u16::try_from(size[1])?];
        let is_new = self.pixels.as_ref().is_none_or(|pixels| pixels.size != size);
        if is_new {
            self.resize(size)?;
        }
        let width = usize::from(size[0]);
        let rows = if is_new || self.take_exposed()? { 0..usize::from(size[1]) } else { rows };
        self.finish_copying()?;
        let changed = words.get(rows.start * width..rows.end * width).ok_or("too few words")?;
        if let Some(pixels) = &self.pixels {
            pixels.file.write_all_at(bytemuck::cast_slice(changed), (rows.start * width * 4) as u64)?;
        }
        self.copy(rows)
    }

    /// Has the server copy everything once more, if it has lost some of it.
    fn restore(&mut self) -> Result<(), Error> {
        let height = self.pixels.as_ref().map_or(0, |pixels| usize::from(pixels.size[1]));
        if self.take_exposed()? { self.copy(0..height) } else { Ok(()) }
    }

    /// Returns whether some of the window was exposed since the last call.
    fn take_exposed(&self) -> Result<bool, Error> {
        let mut is_exposed = false;
        while let Some(event) = self.connection.poll_for_event()? {
            match event {
                Event::Expose(_) => is_exposed = true,
                Event::Error(e) => return Err(format!("{e:?}").into()),
                _ => {}
            }
        }
        Ok(is_exposed)
    }

    /// Replaces the memory file by one for a window of this size.
    fn resize(&mut self, size: [u16; 2]) -> Result<(), Error> {
        if let Some(old) = self.pixels.take() {
            self.connection.shm_detach(old.segment)?;
        }
        let file = File::from(memfd_create("fbptr-window", MemfdFlags::CLOEXEC)?);
        file.set_len(u64::from(size[0]) * u64::from(size[1]) * 4)?;
        let segment = self.connection.generate_id()?;
        self.connection.shm_attach_fd(segment, file.try_clone()?, true)?.check()?;
        self.pixels = Some(SharedPixels { file, segment, size });
        Ok(())
    }

    /// Waits until the server has copied the rows of the last call.
    fn finish_copying(&mut self) -> Result<(), Error> {
        if std::mem::take(&mut self.is_copying) {
            // It answers requests in their order.
            self.connection.get_input_focus()?.reply()?;
        }
        Ok(())
    }

    /// Has the server copy rows to the window.
    fn copy(&mut self, rows: Range<usize>) -> Result<(), Error> {
        let Some(SharedPixels { segment, size: [width, height], .. }) = self.pixels else { return Ok(()) };
        if rows.is_empty() {
            return Ok(());
        }
        let (first, count) = (u16::try_from(rows.start)?, u16::try_from(rows.len())?);
        let format = ImageFormat::Z_PIXMAP.into();
        let at = i16::try_from(first)?;
        let (window, context, depth) = (self.window, self.context, self.depth);
        self.connection.shm_put_image(
            window, context, width, height, 0, first, width, count, 0, at, depth, format, false, segment, 0,
        )?;
        self.connection.flush()?;
        self.is_copying = true;
        Ok(())
    }
}

/// Returns whether pixels of this depth and visual are words 0x00RRGGBB in the machine's byte order.
fn has_plain_words(connection: &RustConnection, depth: u8, visual: u32) -> bool {
    let setup = connection.setup();
    let native = if cfg!(target_endian = "little") { ImageOrder::LSB_FIRST } else { ImageOrder::MSB_FIRST };
    let is_word = setup.pixmap_formats.iter().any(|f| f.depth == depth && f.bits_per_pixel == 32);
    let mut visuals =
        setup.roots.iter().flat_map(|root| &root.allowed_depths).flat_map(|allowed| &allowed.visuals);
    let has_plain_masks = visuals.any(|v| {
        v.visual_id == visual && [v.red_mask, v.green_mask, v.blue_mask] == [0xff_0000, 0xff00, 0xff]
    });
    setup.image_byte_order == native && is_word && has_plain_masks
}
