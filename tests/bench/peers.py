"""Other renderers that join a chart where they are installed: `./dapple chart SCENE.blend --peers`.

Each works in a process of its own, on one thread, on the same geometry: the smooth water that the chart's reference is
made of, as a mesh with its normals. Cycles comes with Blender; Mitsuba 3 is `pip install mitsuba`, and needs LLVM 16 or
newer where the processor has AVX-512. One that is missing, or fails, is told of, and the chart is made without it.
"""

from __future__ import annotations

import importlib.util
import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
_NO_LLVM = "; it needs LLVM 16 or newer: apt-get install libllvm19, or DRJIT_LIBLLVM_PATH=.../libLLVM.so.19.1"
_PATIENCE = 600.0  # s: a peer that takes longer is left out
_LLVM = ("/usr/lib/x86_64-linux-gnu/libLLVM.so.*", "/usr/lib/x86_64-linux-gnu/libLLVM-1[6-9].so*")


def cycles(scene, settings, texels):
    """Shadow caustics of Cycles, baked."""
    return _peer("Cycles", "peer_cycles.py", scene, settings, texels)


def mitsuba(scene, settings, texels):
    """Light tracing with Mitsuba 3."""
    if importlib.util.find_spec("mitsuba") is None:
        yield "Mitsuba 3 is not installed here: pip install mitsuba", None
        return
    yield from _peer("Mitsuba", "peer_mitsuba.py", scene, settings, texels, _NO_LLVM)


PEERS = cycles, mitsuba


def _peer(name, script, scene, settings, texels, hint=""):
    """Yield (sentence, None) while a script works, and (sentence, run) for each of its runs; hint: what to say besides
    where it fails."""
    from dapple.kernels.anchor import Kept
    from dapple.kernels.chart.reference import smooth
    from dapple.kernels.methods import prepare

    yield f"{name}: working", None
    given, _ = smooth(scene, texels, settings, Kept(prepare(scene, texels, settings)))
    with tempfile.TemporaryDirectory() as folder:
        task, answer = Path(folder) / "task", Path(folder) / "answer"
        task.write_bytes(pickle.dumps((given, texels)))
        command = [sys.executable, str(FOLDER / script), str(task), str(answer)]
        said = _run(command)
        if not answer.exists():
            yield f"{name} cannot take part: {said}{hint}", None
            return
        runs = pickle.loads(answer.read_bytes())
    for run in runs:
        yield f"{run['rung']}, {run['label']}: {run['seconds']:.3g} s", run


def _run(command):
    """Run a command to its end; returns the last line of what it said."""
    environment = {**_llvm(), **os.environ}
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        return f"it was not done in {_PATIENCE:.0f} s"
    return (done.stderr.strip() or done.stdout.strip() or f"it ended with {done.returncode}").splitlines()[-1]


def _llvm():
    """Where Dr.Jit finds an LLVM that knows this processor, unless it is told."""
    found = sorted(path for pattern in _LLVM for path in Path("/").glob(pattern.lstrip("/")))
    return {"DRJIT_LIBLLVM_PATH": str(found[-1])} if found else {}


def answer(runs):
    """What a script does: put what runs(scene, texels) yields into the file that its caller named."""
    given, path = sys.argv[1:]
    scene, texels = pickle.loads(Path(given).read_bytes())
    Path(path).write_bytes(pickle.dumps(list(runs(scene, texels))))


def run_of(rung, label, seconds, light, seen=None):
    """A run, as the chart takes it: light (K,3) [W/m^2], and where that is not all, the texels seen (K,)."""
    known = {"rung": rung, "label": label, "method": rung, "asked": None, "seconds": seconds, "runs": 1}
    return {**known, "light": light, "seen": seen}
