//! Pick buffer: the face that last wrote the depth of each pixel. Allocated only when PICK asks for
//! it.

/// Marks a pixel where no face has written depth.
const NO_FACE: [u32; 2] = [u32::MAX; 2];

/// Name number (see `DrawCall::name`) and triangle number of the face at each pixel.
#[derive(Clone, Debug)]
pub struct PickBuffer {
    width: u32,
    height: u32,
    ids: Vec<[u32; 2]>,
}

impl PickBuffer {
    /// Creates a pick buffer of `width` x `height` pixels without any face.
    pub fn new(width: u32, height: u32) -> Self {
        PickBuffer { width, height, ids: vec![NO_FACE; width as usize * height as usize] }
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the size of the buffer in bytes.
    pub fn size_bytes(&self) -> usize {
        std::mem::size_of_val(self.ids.as_slice())
    }

    /// Removes every face.
    pub fn clear(&mut self) {
        self.ids.fill(NO_FACE);
    }

    /// Forgets the faces of these columns and rows; those beyond the frame are ignored.
    pub fn clear_within(&mut self, columns: &std::ops::Range<u32>, rows: &std::ops::Range<u32>) {
        let end = columns.end.min(self.width) as usize;
        let columns = (columns.start as usize).min(end)..end;
        for row in rows.start..rows.end.min(self.height) {
            let at = row as usize * self.width as usize;
            self.ids[at + columns.start..at + columns.end].fill(NO_FACE);
        }
    }

    /// Returns the name number and triangle at pixel (x, y), or `None` off the frame and where no
    /// face wrote depth.
    pub fn get(&self, x: i32, y: i32) -> Option<(u32, u32)> {
        let inside = (x as u32) < self.width && (y as u32) < self.height;
        if !inside {
            return None;
        }
        let id = self.ids[self.width as usize * y as usize + x as usize];
        (id != NO_FACE).then_some((id[0], id[1]))
    }

    /// Returns name and triangle of every pixel for writing, row 0 first.
    pub fn ids_mut(&mut self) -> &mut [[u32; 2]] {
        &mut self.ids
    }

    /// Stores a face at pixel number `index` (= width * y + x).
    ///
    /// # Panics
    /// If `index` is not a pixel of this buffer.
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
        assert_eq!((ids.width(), ids.height(), ids.size_bytes()), (3, 2, 48));
        ids.set(4, 7, 0);
        ids.set(4, 8, 1);
        assert_eq!((ids.get(1, 1), ids.get(0, 0)), (Some((8, 1)), None));
        for (x, y) in [(-1, 0), (-1, 1), (-1, -1), (0, -1), (4, 0), (0, 2), (i32::MIN, i32::MAX)] {
            assert_eq!(ids.get(x, y), None, "({x}, {y})");
        }
        ids.clear();
        assert_eq!(ids.get(1, 1), None);
    }
}
