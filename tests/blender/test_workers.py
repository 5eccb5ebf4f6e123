"""Workers solve as this process would, know no Blender, and never outlive who asked them."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from waves import pool as waves

from dapple.kernels import methods
from dapple.kernels.anchor import Anchor
from dapple.kernels.maps.texels import rasterise
from dapple.kernels.scene import Settings
from dapple.operators.bake import pool, worker
from dapple.operators.bake.memory import memory_per_worker
from dapple.operators.bake.messages import Died, Failed, Job, Rough, Solved, Stage
from dapple.operators.bake.pool import Pool
from dapple.operators.errors import DappleError
from dapple.operators.maps.exr_encode import encode

SETTINGS = Settings(resolution=32, tolerance=0.05)
HEAVY = Job(1, waves(quads=64), Settings(method="conic_walk", resolution=1024, tolerance=1e-4), Anchor())


def last_answers(workers, count):
    """The last answers of so many jobs, by number."""
    found = {}
    while len(found) < count:
        found |= {job.number: answer for job, answer in workers.answers(60) if not isinstance(answer, (Stage, Rough))}
    return found


def is_gone(process, within=1.0):
    """Whether a process ends, or is a zombie at most, within some seconds."""
    until = time.monotonic() + within
    while time.monotonic() < until:
        try:
            if "Z" in Path(f"/proc/{process}/stat").read_text().split(")")[1]:
                return True
        except OSError:
            return True
        time.sleep(0.01)
    return False


def test_two_workers_make_the_bytes_that_this_process_makes():
    jobs = [Job(k, waves(quads=8 + k), SETTINGS, Anchor()) for k in range(4)]
    with Pool(2) as workers:
        found = {}
        for job in jobs:
            while not workers.has_room:
                found |= {j.number: a for j, a in workers.answers(60) if isinstance(a, Solved)}
            workers.give(job)
        found |= last_answers(workers, len(workers.busy))
    for job in jobs:
        texels = [rasterise(r, 32) for r in job.scene.receivers]
        expected = methods.solve(job.scene, texels, SETTINGS)
        assert found[job.number].files == (encode(expected.images[0]),)
        np.testing.assert_array_equal(found[job.number].diagnostics.flux_in, expected.diagnostics.flux_in)
        assert set(found[job.number].seconds) == {"texels", "solve", "write"}


def test_a_worker_finds_the_anchor_and_shows_rough_pictures():
    one = waves(quads=24)
    with Pool(1) as workers:
        workers.give(Job(1, one, SETTINGS))
        anchor = last_answers(workers, 1)[1]
        assert anchor == methods.prepare(one, [rasterise(r, 32) for r in one.receivers], SETTINGS)
        workers.give(Job(1, one, Settings(resolution=32, tolerance=1e-3), anchor, rough=True))
        said = []
        while workers.busy:
            said += [answer for _, answer in workers.answers(60)]
    assert [type(answer) for answer in said if not isinstance(answer, Stage)] == [Rough, Solved]
    assert [answer.text for answer in said if isinstance(answer, Stage)] == ["texels", "light", "maps"]


def test_a_worker_has_blenders_name_for_the_package_and_no_blender(root):
    code = f"""
import sys, runpy
entry = runpy.run_path({str(Path(worker.__file__))!r})
entry["load_solver"]({{"name": "bl_ext.some.dapple", "root": {str(root)!r}, "path": sys.path}})
import bl_ext.some.dapple.kernels.methods
solver = "bl_ext.some.dapple.operators.bake.solver"
print(sorted({{"bpy", "mathutils", "dapple"}} & set(sys.modules)), solver in sys.modules)
"""
    run = subprocess.run([sys.executable, "-I", "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split("\n")[0] == "[] True"


def test_what_a_worker_cannot_do_comes_as_a_sentence():
    with Pool(1) as workers:
        workers.give(Job(7, None, SETTINGS, Anchor()))  # no scene: a fault
        assert "fault of Dapple's" in last_answers(workers, 1)[7].sentence
        workers.give(Job(8, waves(quads=4), SETTINGS, Anchor()))
        assert isinstance(last_answers(workers, 1)[8], Solved), "it goes on"
    with Pool(1) as workers:
        workers.give(Job(9, waves(quads=4), Settings(method="magic"), Anchor()))
        failed = last_answers(workers, 1)[9]
        assert isinstance(failed, Failed)
        assert "method must be auto or one of" in failed.sentence
        assert "Traceback" in failed.details


def test_a_worker_that_is_killed_is_told_and_replaced():
    with Pool(1) as workers:
        workers.give(HEAVY)
        workers.answers(60)
        workers._workers[0]._process.kill()
        died = last_answers(workers, 1)[1]
        assert died == Died(-9)
        assert workers.has_room and not workers.busy
        workers.give(Job(2, waves(quads=4), SETTINGS, Anchor()))
        assert isinstance(last_answers(workers, 1)[2], Solved)


def test_a_worker_that_dies_while_it_rests_is_replaced_in_silence():
    with Pool(1) as workers:
        workers.give(Job(1, waves(quads=4), SETTINGS, Anchor()))
        last_answers(workers, 1)
        workers._workers[0]._process.kill()
        workers._workers[0]._process.wait()
        workers.give(Job(2, waves(quads=4), SETTINGS, Anchor()))
        assert isinstance(last_answers(workers, 1)[2], Solved)


def test_closing_ends_workers_at_once_in_the_midst_of_a_frame():
    workers = Pool(2)
    for number in (1, 2):
        workers.give(Job(number, HEAVY.scene, HEAVY.settings, Anchor()))
    workers.answers(60)
    processes = [w._process.pid for w in workers._workers]
    start = time.monotonic()
    workers.close()
    assert time.monotonic() - start < 1
    assert all(is_gone(process, 0.1) for process in processes)


PARENT = """
import os, runpy, signal, sys
runpy.run_path(sys.argv[1] + "/tests/conftest.py")
sys.path.append(sys.argv[1] + "/tests")
from dapple.tests.blender.test_workers import HEAVY
from dapple.operators.bake.pool import Pool

workers = Pool(1)
workers.give(HEAVY)
while not any(getattr(answer, "text", "") == "light" for _, answer in workers.answers(60)):
    pass
print(workers._workers[0]._process.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at /proc")
@pytest.mark.bpy_module
def test_workers_end_with_a_parent_that_is_killed(root):
    run = subprocess.run([sys.executable, "-c", PARENT, str(root)], capture_output=True, text=True)
    assert run.returncode == -9, run.stderr
    assert is_gone(int(run.stdout), 2.0)


def test_a_python_that_does_not_start_is_said(monkeypatch, tmp_path):
    for wrong in (str(tmp_path / "python9"), "", "/usr/bin/blender"):
        monkeypatch.setattr(pool.sys, "executable", wrong)
        with pytest.raises(DappleError, match=r"Blender's Python, .*, does not start"):
            Pool(1).give(HEAVY)


def test_no_worker_takes_more_than_one_thread_of_numpy():
    with Pool(1) as workers:
        workers.give(Job(1, waves(quads=4), SETTINGS, Anchor()))
        last_answers(workers, 1)
        environment = Path(f"/proc/{workers._workers[0]._process.pid}/environ").read_bytes().split(b"\0")
    assert b"OPENBLAS_NUM_THREADS=1" in environment


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="looks at /proc")
def test_a_worker_takes_about_what_is_stated():
    settings = Settings(resolution=512)
    job = Job(1, waves(quads=128), settings, Anchor())
    with Pool(1) as workers:
        workers.give(job)
        assert isinstance(last_answers(workers, 1)[1], Solved)
        status = Path(f"/proc/{workers._workers[0]._process.pid}/status").read_text().splitlines()
    (peak,) = (1024 * int(line.split()[1]) for line in status if line.startswith("VmHWM"))
    stated = memory_per_worker(len(job.scene.water.triangles), 0, 2, (512,), settings)
    assert 0.5 < stated / peak < 2
