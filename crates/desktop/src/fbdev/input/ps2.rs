//! A PS/2 mouse as `drivers/input/mousedev.c` emulates it: packets of three bytes, or of four with
//! a wheel once the program has knocked for it.

/// Sample rates whose setting turns the wheel on.
const KNOCK: [u8; 6] = [0xf3, 200, 0xf3, 100, 0xf3, 80];
/// Answer to every command.
const ACKNOWLEDGE: u8 = 0xfa;

/// State of a program's mouse.
#[derive(Debug, Default)]
pub struct Ps2 {
    has_wheel: bool,
    /// Bytes of the knock that have come.
    knocked: usize,
}

impl Ps2 {
    /// Takes a byte that the program has written, and returns the answer.
    pub fn command(&mut self, byte: u8) -> Vec<u8> {
        self.knocked = match byte {
            _ if byte == KNOCK[self.knocked] => self.knocked + 1,
            _ if byte == KNOCK[0] => 1,
            _ => 0,
        };
        if self.knocked == KNOCK.len() {
            (self.has_wheel, self.knocked) = (true, 0);
            return vec![ACKNOWLEDGE];
        }
        match byte {
            // The mouse's kind, its state, and a reset.
            0xf2 => vec![ACKNOWLEDGE, if self.has_wheel { 3 } else { 0 }],
            0xe9 => vec![ACKNOWLEDGE, 0x60, 3, 200],
            0xff => {
                *self = Ps2::default();
                vec![ACKNOWLEDGE, 0xaa, 0]
            }
            _ => vec![ACKNOWLEDGE],
        }
    }

    /// Returns the packets of a movement. `buttons` is 1 left, 2 middle, 4 right; y points down in
    /// the frame and up in a packet.
    pub fn packets(&self, dx: i32, dy: i32, wheel: i32, buttons: u8) -> Vec<u8> {
        let (mut dx, mut dy, mut wheel) = (dx, dy.saturating_neg(), wheel.saturating_neg());
        // PS/2 has the right button before the middle one.
        let held = buttons & 1 | (buttons & 4) >> 1 | (buttons & 2) << 1;
        let mut packets = Vec::new();
        loop {
            let step = |v: &mut i32, most: i32| {
                let part = (*v).clamp(-most, most);
                *v -= part;
                part
            };
            let (x, y, z) = (step(&mut dx, 127), step(&mut dy, 127), step(&mut wheel, 7));
            packets.push(8 | held | u8::from(x < 0) << 4 | u8::from(y < 0) << 5);
            packets.extend([x as u8, y as u8]);
            if self.has_wheel {
                packets.push(z as u8);
            }
            if (dx, dy) == (0, 0) && (wheel == 0 || !self.has_wheel) {
                return packets;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_movements_are_several_packets() {
        let mouse = Ps2::default();
        assert_eq!(mouse.packets(-130, 1, 0, 4), [0x3a, 0x81, 0xff, 0x1a, 0xfd, 0]);
        let total: i32 =
            mouse.packets(i32::from(u16::MAX), 0, 9, 0).chunks(3).map(|p| i32::from(p[1] as i8)).sum();
        assert_eq!(total, i32::from(u16::MAX));
    }

    #[test]
    fn only_the_whole_knock_turns_the_wheel_on() {
        for (bytes, kind) in [
            (&[0xf3, 200, 0xf3, 100, 0xf3, 80][..], 3),
            (&[0xf3, 200, 0xf3, 200, 0xf3, 80], 0),
            (&[0xf3, 0xf3, 200, 0xf3, 100, 0xf3, 80], 3),
            (&[0xf3, 200, 0xf3, 100, 0xf3, 80, 0xff], 0),
        ] {
            let mut mouse = Ps2::default();
            for byte in bytes {
                mouse.command(*byte);
            }
            assert_eq!(mouse.command(0xf2), [0xfa, kind], "{bytes:x?}");
        }
    }
}
