"""Bake Animation, killed at random moments, against the same without: `kill_test.py [FRAMES] [KILLS] [SEED]`.

Every other kill takes the main process only, whose workers have to end by themselves. Prints what happened, and ends
with code 1 where a file differs.
"""

import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def main(frames=250, kills=5, seed=0):
    """Bake twice, compare."""
    import bpy

    import dapple
    from dapple.tests.blender.killing import bake_whole, differences, kill_often, save_waves

    bpy.ops.wm.read_factory_settings(use_empty=True)
    dapple.register()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        save_waves(folder / "waves.blend", frames)
        start = time.monotonic()
        bake_whole(folder / "waves.blend", folder / "whole", 2)
        print(f"{frames} frames without a kill: {time.monotonic() - start:.0f} s", flush=True)
        for sentence in kill_often(folder / "waves.blend", folder / "killed", 2, frames, kills, seed):
            print(sentence, flush=True)
        unequal = differences(folder / "whole", folder / "killed")
        maps = len(list((folder / "killed").rglob("*.exr")))
    print(f"{maps} maps and bake.json: " + (f"{len(unequal)} differ: {unequal[:5]}" if unequal else "no bit differs"))
    return bool(unequal)


if __name__ == "__main__":
    import runpy

    runpy.run_path(str(ROOT / "tests" / "conftest.py"))
    sys.exit(main(*map(int, sys.argv[1:])))
