"""Maps as OpenEXR's own reader sees them, which is none of ours.

Beside the OpenEXR that Blender itself brings, that of the Python package crashes (Blender 4.3.2): in Blender this file
reads in a process of its own.
"""

import io
import subprocess
import sys

import numpy as np


def read_exr(path):
    """(H,W,3) as stored, half or float32, row 0 at v = 0; AssertionError where there is another channel."""
    import bpy

    if not bpy.app.binary_path:
        return _read(path)
    done = subprocess.run([sys.executable, __file__, str(path)], stdout=subprocess.PIPE, check=True)
    return np.load(io.BytesIO(done.stdout))


def _read(path):
    import OpenEXR

    channels = OpenEXR.File(str(path)).channels()
    assert list(channels) == ["RGB"]
    return channels["RGB"].pixels[::-1]


if __name__ == "__main__":
    content = io.BytesIO()
    np.save(content, _read(sys.argv[1]))
    sys.stdout.buffer.write(content.getvalue())
