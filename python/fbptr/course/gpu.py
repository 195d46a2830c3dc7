"""The simulated GPU of the course framework "Renderizador", on this package's memory.

In: a student's calls of `GPU.draw_pixel`, `read_pixel` and the functions of frame buffers. Out: the
pixels of `Framebuffer`s: the colours of an attachment are a view of a framebuffer's own bytes (RGB8 its
first three channels, RGBA8 all four), depths are an array. Needs numpy, and Pillow for textures.

Right is: the same calls leave the same colours and depths as the framework's own module, exceptions
included, so that a picture tells about the student's code alone. What decides pictures is kept:

- `draw_pixel` ignores data of zeros alone: black is not drawn over another colour, nor depth 0 over
  another depth.
- Colours that are no integers are cut off, not rounded; a depth buffer of 16 bits is of integers.
- `read_pixel` returns a view of the buffer: later drawing changes what was read.
- The buffer that is checked in `read_pixel` is that for drawing, the one that is read that for reading.

Not kept: `save_image` writes the picture as it is read, and the framework's quiet mode, which saves a
picture before anything is drawn, is one that draws (see `fbptr.course.renderizador`).
"""

import os
import sys
import types

import numpy as np

from ..framebuffer import Framebuffer


class FrameBuffer:
    """A frame buffer object: its colours, depths, and the framebuffer that holds the colours."""

    def __init__(self):
        self.color = np.empty(0)
        self.depth = np.empty(0)
        self.framebuffer = None


class GPU:
    """The GPU. All is static, as in the framework: there is one."""

    DRAW_FRAMEBUFFER = 0b01
    READ_FRAMEBUFFER = 0b10
    FRAMEBUFFER = 0b11

    RGB8 = 0b001
    RGBA8 = 0b010
    DEPTH_COMPONENT16 = 0b101
    DEPTH_COMPONENT32F = 0b110

    COLOR_ATTACHMENT = 0
    DEPTH_ATTACHMENT = 1

    image_file = None
    frame_buffer = None
    path = "."

    def __init__(self, image_file, path):
        """Begins anew: no frame buffers, black and depth 1 for clearing. `path` is the folder of textures."""
        GPU.image_file = image_file
        GPU.frame_buffer = []
        GPU.draw_framebuffer = 0
        GPU.read_framebuffer = 0
        GPU.clear_color_val = [0, 0, 0]
        GPU.clear_depth_val = 1.0
        GPU.path = path

    @staticmethod
    def gen_framebuffers(size):
        """Makes `size` frame buffers without memory, and returns their positions."""
        first = len(GPU.frame_buffer)
        GPU.frame_buffer.extend(FrameBuffer() for _ in range(size))
        return list(range(first, first + size))

    @staticmethod
    def bind_framebuffer(buffer, position):
        """Makes a frame buffer the one that is drawn into, read from, or both."""
        if buffer in (GPU.DRAW_FRAMEBUFFER, GPU.FRAMEBUFFER):
            GPU.draw_framebuffer = position
        if buffer in (GPU.READ_FRAMEBUFFER, GPU.FRAMEBUFFER):
            GPU.read_framebuffer = position

    @staticmethod
    def framebuffer_storage(position, attachment, mode, width, height):
        """Gives a frame buffer memory: colours of zeros, or depths of ones."""
        target = GPU.frame_buffer[position]
        if attachment == GPU.COLOR_ATTACHMENT:
            target.framebuffer = Framebuffer(width, height)
            pixels = target.framebuffer.numpy()
            if mode == GPU.RGB8:
                target.color = pixels[:, :, :3]
            else:
                target.color = pixels
                target.color[:] = 0
        elif attachment == GPU.DEPTH_ATTACHMENT:
            kind = np.uint16 if mode == GPU.DEPTH_COMPONENT16 else np.float32
            target.depth = np.ones((height, width, 1), dtype=kind)

    @staticmethod
    def clear_color(color):
        """Sets the colour of `clear_buffer`."""
        GPU.clear_color_val = color

    @staticmethod
    def clear_depth(depth):
        """Sets the depth of `clear_buffer`."""
        GPU.clear_depth_val = depth

    @staticmethod
    def clear_buffer():
        """Clears colours and depths of the frame buffer that is drawn into."""
        target = GPU.frame_buffer[GPU.draw_framebuffer]
        if target.color.size != 0:
            target.color[:] = GPU.clear_color_val
        if target.depth.size != 0:
            target.depth[:] = GPU.clear_depth_val

    @staticmethod
    def draw_pixel(coord, mode, data):
        """Sets the colour or depth of pixel [x, y], y down. Data of zeros alone is ignored."""
        if not coord or not np.any(data):
            return
        target = GPU.frame_buffer[GPU.draw_framebuffer]
        buffer = _attachment(target, mode, GPU.draw_framebuffer)
        x, y = _place(coord, buffer, "write")
        if mode in (GPU.RGB8, GPU.RGBA8):
            if not _is_color(data, mode + 2):
                raise ValueError("a colour is %d numbers from 0 to 255, not %r" % (mode + 2, data))
        elif not (isinstance(data, (list, tuple, np.ndarray)) and len(data) == 1):
            raise ValueError("a depth is a list of one number, not %r" % (data,))
        buffer[y][x] = data

    @staticmethod
    def read_pixel(coord, mode):
        """Returns the colour or depth of pixel [x, y], a view of the frame buffer that is read."""
        if not coord:
            return None
        _attachment(GPU.frame_buffer[GPU.draw_framebuffer], mode, GPU.draw_framebuffer)
        buffer = _attachment(GPU.frame_buffer[GPU.read_framebuffer], mode, GPU.read_framebuffer)
        x, y = _place(coord, buffer, "read")
        return buffer[y][x]

    @staticmethod
    def picture():
        """Returns the frame buffer that is read as a `Framebuffer`."""
        return picture_of(GPU.frame_buffer[GPU.read_framebuffer].color)

    @staticmethod
    def save_image():
        """Writes the picture that is read, to the first free name NAME000.png, NAME001.png, ..."""
        name, ending = os.path.splitext(GPU.image_file)
        counter = 0
        while os.path.exists("%s%03d%s" % (name, counter, ending)):
            counter += 1
        GPU.picture().save("%s%03d%s" % (name, counter, ending))

    @staticmethod
    def load_texture(textura):
        """Reads a picture as an array indexed by [x][y]."""
        from PIL import Image

        with Image.open(os.path.join(GPU.path, textura)) as image:
            return np.swapaxes(np.array(image), 0, 1)

    @staticmethod
    def get_frame_buffer():
        """Returns the colours of the frame buffer that is read, indexed by [y][x]."""
        return GPU.frame_buffer[GPU.read_framebuffer].color

    @staticmethod
    def swap_buffers():
        """Does nothing, as in the framework."""


def take_functions(path):
    """Takes what a student's `gpu.py` adds to the GPU: functions of other names, and a `swap_buffers`.

    Returns a function that removes them. A module that does not load here adds nothing.
    """
    module = types.ModuleType("student_gpu")
    module.__file__ = path
    try:
        with open(path, "rb") as file:
            exec(compile(file.read(), path, "exec"), module.__dict__)
    except Exception as failure:
        print("%s adds nothing to the GPU: %s" % (path, failure), file=sys.stderr)
        return lambda: None
    theirs = vars(getattr(module, "GPU", object))
    taken = {name: value for name, value in theirs.items() if name == "swap_buffers" or not hasattr(GPU, name)}
    before = {name: vars(GPU)[name] for name in taken if name in vars(GPU)}
    for name, value in taken.items():
        setattr(GPU, name, value)
    # Their functions speak of the one GPU.
    module.GPU = GPU

    def give_back():
        for name in taken:
            if name in before:
                setattr(GPU, name, before[name])
            else:
                delattr(GPU, name)

    return give_back


def picture_of(color):
    """Returns colours, indexed by [y][x], as a `Framebuffer`: the own one of a frame buffer, or a copy."""
    color = np.asarray(color)
    for target in GPU.frame_buffer:
        # A student's code may have put an array of another size in the place of the colours.
        if target.color is color and target.framebuffer is not None:
            pixels = target.framebuffer.numpy()
            if color.shape[:2] == pixels.shape[:2] and np.shares_memory(color, pixels):
                return target.framebuffer
    height, width = color.shape[:2]
    fb = Framebuffer(width, height)
    fb.numpy()[:, :, : color.shape[2]] = color
    return fb


def _attachment(target, mode, position):
    if mode in (GPU.RGB8, GPU.RGBA8):
        buffer, what = target.color, "colours"
    elif mode in (GPU.DEPTH_COMPONENT16, GPU.DEPTH_COMPONENT32F):
        buffer, what = target.depth, "depths"
    else:
        raise ValueError("there is no mode %r of a frame buffer" % (mode,))
    if buffer.size == 0:
        raise ValueError("frame buffer %d has no memory for %s" % (position, what))
    return buffer


def _place(coord, buffer, what):
    x, y = coord[0], coord[1]
    height, width = buffer.shape[:2]
    if x < 0 or x >= width or y < 0 or y >= height:
        raise IndexError("%s at [%s, %s], outside a frame buffer of %dx%d" % (what, x, y, width, height))
    return x, y


def _is_color(data, count):
    return (
        isinstance(data, (list, tuple, np.ndarray)) and len(data) == count and all(0 <= i <= 255 for i in data)
    )
