//! Pick buffer: the face that was last written to the depth of each pixel. Made only when PICK asks
//! for it.

/// No face: nothing that writes depth was drawn here.
const NO_FACE: [u32; 2] = [u32::MAX; 2];

/// For each pixel, the number of the thing drawn (what `DrawCall::name` said) and of its triangle.
#[derive(Clone, Debug)]
pub struct PickBuffer {
    width: u32,
    height: u32,
    ids: Vec<[u32; 2]>,
}

impl PickBuffer {
    /// Makes a pick buffer of `width` x `height` pixels without any face.
    pub fn new(width: u32, height: u32) -> Self {
        PickBuffer { width, height, ids: vec![NO_FACE; width as usize * height as usize] }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Bytes that the buffer takes.
    pub fn size_bytes(&self) -> usize {
        std::mem::size_of_val(self.ids.as_slice())
    }

    /// Forgets every face.
    pub fn clear(&mut self) {
        self.ids.fill(NO_FACE);
    }

    /// The name number and triangle at pixel (x, y); `None` where no face wrote depth, and off the frame.
    pub fn get(&self, x: i32, y: i32) -> Option<(u32, u32)> {
        let inside = (x as u32) < self.width && (y as u32) < self.height;
        let id = *self.ids.get(self.width as usize * y as usize + x as usize).filter(|_| inside)?;
        (id != NO_FACE).then_some((id[0], id[1]))
    }

    /// Name and triangle of every pixel, row 0 first, for writing.
    pub fn ids_mut(&mut self) -> &mut [[u32; 2]] {
        &mut self.ids
    }

    /// Remembers a face at pixel number `index` (= width * y + x).
    ///
    /// # Panics
    /// When `index` is not a pixel of this memory.
    #[inline]
    pub fn set(&mut self, index: usize, name: u32, triangle: u32) {
        self.ids[index] = [name, triangle];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remembers_the_last_face_and_nothing_off_the_frame() {
        let mut ids = PickBuffer::new(3, 2);
        ids.set(4, 7, 0);
        ids.set(4, 8, 1);
        assert_eq!((ids.get(1, 1), ids.get(0, 0)), (Some((8, 1)), None));
        assert_eq!((ids.get(-1, 0), ids.get(4, 0), ids.get(0, 2)), (None, None, None));
        ids.clear();
        assert_eq!(ids.get(1, 1), None);
    }
}
