"""Worker processes: jobs go in, answers come out, and none outlives its parent. No Blender in here.

Long-lived Python threads are not safe inside Blender, so that the parent polls; what a worker sends in the meantime
waits in its pipe. A worker is Blender's own Python, started anew: it takes a third of a second, and shares neither
memory nor libraries with Blender.
"""

from __future__ import annotations

import contextlib
import errno
import os
import pickle
import subprocess
import sys
from multiprocessing import Pipe, connection
from pathlib import Path

from ..errors import DappleError
from .messages import Died, Rough, Stage

_ROOT = Path(__file__).resolve().parents[2]
_ENTRY = Path(__file__).with_name("worker.py")
# More threads of numpy's libraries only spin beside each other, and other sums than one thread's are other bits.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
# glibc would give the memory of arrays back and take it again, zeroed: a tenth of the time, where two workers do so.
_KEEP_MEMORY = {"MALLOC_MMAP_THRESHOLD_": str(2**25), "MALLOC_TRIM_THRESHOLD_": str(2**29)}
_NO_START = "Blender's Python, {}, does not start ({}); Dapple solves in processes of it. Reinstall Blender."


class Pool:
    """At most `most` workers, started when there is work for them. Close it, or use it in a `with`."""

    def __init__(self, most):
        self.most, self._workers = most, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def busy(self):
        """The Jobs that workers have."""
        return [worker.job for worker in self._workers if worker.job is not None]

    @property
    def has_room(self):
        """Whether a worker waits for a job, or may be started."""
        return len(self.busy) < self.most

    def give(self, job):
        """Hand a Job to a worker that has none. Raises DappleError where no process can be started."""
        for worker in [w for w in self._workers if w.job is None and w.has_ended]:
            self._workers.remove(worker)
            worker.kill()
        idle = next((worker for worker in self._workers if worker.job is None), None)
        if idle is None:
            idle = _Worker()
            self._workers.append(idle)
        idle.give(job)

    def answers(self, seconds=None):
        """[(Job, answer)] of what workers have said by now; waits for some at most so many seconds, None for ever.

        A worker's last answer to its Job makes it idle; one that dies answers Died, and is dropped. One that dies while
        it has none is dropped in silence.
        """
        said = []
        for ready in connection.wait([worker.answers for worker in self._workers], seconds) if self._workers else ():
            worker = next(w for w in self._workers if w.answers is ready)
            job, answer = worker.job, worker.answer()
            if isinstance(answer, Died):
                self._workers.remove(worker)
                worker.kill()
            if job is not None:
                said.append((job, answer))
        return said

    def close(self):
        """End all workers at once, whatever they are at: none is waited for before all are killed, since the system
        takes its time to take back a gigabyte."""
        for worker in self._workers:
            worker.end()
        for worker in self._workers:
            worker.kill()
        self._workers = []


class _Worker:
    """One process, and the Job that it has, or None."""

    def __init__(self):
        self.job = None
        theirs, self._jobs = Pipe(duplex=False)
        self.answers, their_answers = Pipe(duplex=False)
        try:
            self._process = _start(theirs, their_answers)
        except OSError as error:
            self._jobs.close()
            self.answers.close()
            raise DappleError(_NO_START.format(sys.executable, error.strerror or error)) from error
        finally:
            theirs.close()
            their_answers.close()
        self._send({"name": __package__.rsplit(".", 2)[0], "root": str(_ROOT), "path": [str(p) for p in sys.path]})

    @property
    def has_ended(self):
        return self._process.poll() is not None

    def give(self, job):
        self.job = job
        self._send(job)

    def _send(self, message):
        with contextlib.suppress(OSError):  # it died: the end of its answers says so
            self._jobs.send_bytes(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))

    def answer(self):
        """What it says next, Died for nothing more; waits for the rest of an answer that has begun."""
        try:
            answer = pickle.loads(self.answers.recv_bytes())
        except (EOFError, OSError):
            self.end()
            return Died(self._process.wait())
        if not isinstance(answer, (Stage, Rough)):
            self.job = None
        return answer

    def end(self):
        self._process.kill()

    def kill(self):
        self.end()
        self._process.wait()
        self._jobs.close()
        self.answers.close()


def _start(jobs, answers):
    """The process that reads jobs from one pipe's end and writes answers to another's."""
    if "python" not in Path(sys.executable or "").name.lower():
        raise FileNotFoundError(errno.ENOENT, "that is no Python")
    ends = [jobs.fileno(), answers.fileno()]
    flags = ["-I"] + ["-B"] * sys.dont_write_bytecode
    command = [sys.executable, *flags, str(_ENTRY), *map(str, ends)]
    environment = {**os.environ, **dict.fromkeys(_ONE_THREAD, "1"), **_KEEP_MEMORY}
    given = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "env": environment}
    if sys.platform != "win32":
        return subprocess.Popen(command, pass_fds=ends, **given)
    for end in ends:
        os.set_handle_inheritable(end, True)
    start = subprocess.STARTUPINFO(lpAttributeList={"handle_list": ends})
    return subprocess.Popen(command, startupinfo=start, creationflags=subprocess.CREATE_NO_WINDOW, **given)
