"""One bake under way: frames are read in order, solved by workers in any order, and written as they come back.

At most one frame that was read waits for a worker. A frame is not solved where its maps are on disk, made from the same
inputs, nor where nothing differs from an earlier one of the bake, whose maps it then gets.
"""

from __future__ import annotations

import sys
import time
from collections import deque
from dataclasses import dataclass, field

import bpy

from ...kernels.anchor import Anchor
from ...kernels.scene import Scene
from ..errors import DappleError
from ..maps.frame_files import copy_maps, write_maps
from ..read.density import Sizes
from ..read.digest import code, digest
from ..read.extract import read_scene
from ..read.mesh_arrays import TopologyCache
from .memory import count_workers, memory_per_worker
from .messages import Died, Failed, Job, Rough, Solved, Stage
from .progress import Preview, Progress, Waiting
from .record import frame_entry, summary
from .remarks import check_maps, remarks

_SLICE = 0.2  # s of sleep of a bake that blocks, so that Ctrl-C is heard on every system
_KILLED = (
    "the process that solved it ended before it was done (code {}). Most likely the system ended it for want of "
    "memory: set fewer workers or a lower resolution and bake again. Else the console says why."
)


@dataclass
class _Frame:
    """A frame that was read; sizes: of its maps; inputs: the digest of all that its maps follow from."""

    number: int
    scene: Scene | None
    sizes: tuple[int, ...]
    warnings: list
    seconds: dict = field(default_factory=dict)
    inputs: str = ""


class Run:
    """The bake of a request by a Timeline, a Record and a Pool; previews: a folder for rough pictures, or None; wait:
    None, or where people work on meanwhile, the seconds that they can be kept waiting for workers."""

    def __init__(self, timeline, request, record, pool, previews=None, wait=None):
        self._timeline, self._request, self._record, self._pool = timeline, request, record, pool
        self._interactive, self._pause = wait is not None, _SLICE if wait is None else wait
        self._previews, self._topology, self._anchor = previews, TopologyCache(), None
        self._sizes = Sizes(request.settings.resolution, request.density)
        self._todo, self._ahead, self._held, self._again = deque(request.frames), None, None, deque()
        self._given, self._stages, self._tried = {}, {}, set()  # number -> _Frame and word; numbers
        self._first, self._equal = {}, {}  # digest -> number; number -> later _Frames that do not differ from it
        self._done, self._solved, self._begun, self._error = 0, 0, None, None

    def steps(self):
        """Yield a Preview or Progress for whatever there is, and for people a Waiting where there is nothing.

        A frame that fails raises its DappleError when what other workers have is on disk.
        """
        self._anchor = yield from self._find_anchor()
        while self._todo or self._held or self._again or self._pool.busy:
            for job, answer in self._pool.answers(0 if self._can_read() else self._pause):
                yield from self._take(job.number, answer)
            self._hand_out()
            if self._can_read():
                yield from self._read_next()
                self._hand_out()
            if self._interactive:
                yield self._waiting()
        if self._error:
            raise self._error[1]

    def _find_anchor(self):
        """The Anchor of the animation; that of no frame, where its frame cannot be read and is not asked for."""
        number = self._request.frames[0] if self._request.anchor is None else self._request.anchor
        try:
            frame = self._read(number)
            self._sizes.keep(frame.scene)
            self._set_workers(frame)
            self._pool.give(Job(number, frame.scene, self._request.settings, sizes=frame.sizes))
            answer = Stage("")
            while isinstance(answer, Stage):
                for _, answer in self._pool.answers(self._pause):
                    self._stages = {number: answer.text} if isinstance(answer, Stage) else {}
                if self._interactive:
                    yield self._waiting()
            if not isinstance(answer, Anchor):
                raise self._failure(number, answer)
        except DappleError:
            if number in self._request.frames:
                raise
            return Anchor()
        if number == self._todo[0]:
            self._ahead = frame
        return answer

    def _set_workers(self, frame):
        """Bound the workers by cores, memory and frames; light that is kept from frame to frame needs one for all."""
        request, scene = self._request, frame.scene
        groups = ((scene.water,), scene.casters, scene.receivers)
        counts = (sum(len(mesh.triangles) for mesh in group) for group in groups)
        each = memory_per_worker(*counts, frame.sizes, request.settings)
        one = bool(request.settings.reuse)
        self._pool.most = 1 if one else count_workers(request.workers, len(request.frames), each)

    def _read(self, number):
        """The _Frame of a number; raises DappleError for what cannot be baked."""
        start, request = time.perf_counter(), self._request
        try:
            depsgraph = self._timeline.at(number)
            scene, warnings = read_scene(depsgraph, request.water, request.receivers, self._topology, request.volume)
            sizes = self._sizes.of(scene)
            check_maps([receiver.name for receiver in scene.receivers], sizes)
        except DappleError as error:
            raise DappleError(f"Frame {number}: {error}") from error
        finally:
            if self._interactive:
                self._timeline.rest()
        return _Frame(number, scene, sizes, warnings, {"extract": time.perf_counter() - start})

    def _can_read(self):
        """Whether to read a frame now: not while Blender renders, which reads the scene as well."""
        return bool(self._todo) and not self._held and not self._again and not bpy.app.is_job_running("RENDER")

    def _read_next(self):
        """Read the next frame and hold it; yields a Progress instead where it need not be solved."""
        number, ahead, self._ahead = self._todo.popleft(), self._ahead, None
        try:
            frame = ahead or self._read(number)
        except DappleError as error:
            self._fail(number, error)
            return
        request, reused = self._request, bool(self._request.settings.reuse)
        known = (frame.scene, frame.sizes, request.settings, request.full, self._anchor, frame.warnings)
        frame.inputs = digest(code(), *known)
        entry = None if reused else self._record.known(number, frame.inputs)
        first = number if reused else self._first.setdefault(frame.inputs, number)
        if entry:
            yield self._progress(number, entry, f"Frame {number} is on disk, made from the same: left as it is.")
        elif first == number:
            self._held = frame
        else:
            frame.scene = None
            if first in self._given or (self._held and self._held.number == first):
                self._equal.setdefault(first, []).append(frame)
            else:
                yield self._copy(frame, first)

    def _hand_out(self):
        """Give a worker that waits the frame that is held. One that a worker has died of is tried again alone."""
        if self._again:
            if not self._pool.busy:
                self._give(self._again.popleft())
        elif self._held and self._pool.has_room and not self._tried & self._given.keys():
            frame, self._held = self._held, None
            self._give(frame)

    def _give(self, frame):
        self._begun = self._begun or time.monotonic()
        self._given[frame.number] = frame
        request = self._request
        rough = self._previews is not None
        wanted = (request.settings, self._anchor, request.full, rough, frame.sizes)
        self._pool.give(Job(frame.number, frame.scene, *wanted))

    def _take(self, number, answer):
        """Yield what there is to tell of a worker's answer."""
        if isinstance(answer, Stage):
            self._stages[number] = answer.text
        elif isinstance(answer, Rough):
            write_maps(self._previews, number, self._given[number].scene, answer.files)
            yield Preview(number, self._previews)
        else:
            frame = self._given.pop(number)
            self._stages.pop(number, None)
            if isinstance(answer, Solved):
                self._hand_out()  # first: the worker need not wait for the disk
                yield from self._finish(frame, answer)
            elif isinstance(answer, Died) and number not in self._tried and not self._request.settings.reuse:
                self._tried.add(number)
                self._again.append(frame)
            else:
                self._fail(number, self._failure(number, answer))

    def _finish(self, frame, solved):
        """Put a frame on disk, and those that do not differ from it; yields their Progress."""
        start = time.perf_counter()
        written = write_maps(self._request.out, frame.number, frame.scene, solved.files)
        seconds = {**frame.seconds, **solved.seconds}
        seconds["write"] += time.perf_counter() - start
        warnings = [*frame.warnings, *remarks(solved.diagnostics)]
        entry = frame_entry(frame.scene, solved.diagnostics, seconds, warnings)
        entry = {**entry, **written, "inputs": frame.inputs}
        self._record.add(frame.number, entry)
        self._solved += 1
        yield self._progress(frame.number, entry, summary(frame.number, entry))
        for equal in self._equal.pop(frame.number, ()):
            yield self._copy(equal, frame.number)

    def _copy(self, frame, first):
        """Put a frame on disk that does not differ from the `first`; returns its Progress."""
        start, entry = time.perf_counter(), self._record.entry(first)
        written = copy_maps(self._request.out, frame.number, entry["files"])
        seconds = {**frame.seconds, "texels": 0.0, "solve": 0.0, "write": time.perf_counter() - start}
        entry = {**entry, **written, "seconds": seconds, "same_as": first}
        self._record.add(frame.number, entry)
        return self._progress(frame.number, entry, f"Frame {frame.number} is as frame {first}: nothing differs.")

    def _progress(self, number, entry, message):
        self._done += 1
        maps = tuple(self._request.out / file for file in entry["files"].values())
        return Progress(number, self._done, len(self._request.frames), message, maps, tuple(entry["warnings"]))

    def _waiting(self):
        total = len(self._request.frames)
        words = [f"frame {number}: {word}" for number, word in sorted(self._stages.items())]
        left = None
        if self._solved:
            left = (time.monotonic() - self._begun) / self._solved * (total - self._done)
        return Waiting(self._done, total, ", ".join(words), left)

    def _fail(self, number, error):
        """Take in no more frames; of several errors that of the earliest frame is told."""
        self._todo.clear()
        self._again.clear()
        self._held = None
        self._error = min(self._error or (number, error), (number, error), key=lambda one: one[0])

    def _failure(self, number, answer):
        """The DappleError that a Failed or Died answer is."""
        if isinstance(answer, Died):
            return DappleError(f"Frame {number}: {_KILLED.format(answer.code)}")
        assert isinstance(answer, Failed)
        if answer.details:
            print(answer.details, file=sys.stderr)
        return DappleError(f"Frame {number}: {answer.sentence}")
