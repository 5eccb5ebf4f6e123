"""How many workers a bake gets, and how much memory each takes."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ...kernels.maps.shelves import count_sheets

# Fitted to what tests/bench/bench_workers.py measures: bytes of a worker without a frame, for the texels of all images,
# and for each triangle of the water and of receivers; where glass or metal casts, at least, and for each texel under
# each triangle of it.
_BASE, _TEXEL, _POWER, _TRIANGLE, _RECEIVER = 57e6, 6970.0, 0.8, 200.0, 1000.0
_CASTING, _CAST = 200e6, 0.043
_WAYS, _WAY = 500e6, 8000.0  # ways of light that are kept from frame to frame: at most, and for each texel
_FINER = 58.0  # triangles of the smooth water, times the square root of texels of one map over tolerance
_SHARE = 0.8  # of the memory that is free


def memory_per_worker(water, casters, receivers, sizes, settings):
    """About how many bytes a worker takes at its peak, for so many triangles of water, of what else casts and of
    receivers, and maps of `sizes`.

    The smooth water gets as many triangles as texels and tolerance ask for. Light is summed in blocks, which take the
    same for all, so that large maps take less for each texel.
    """
    texels = max(sizes, default=0) ** 2
    finer = _FINER * (texels / settings.tolerance) ** 0.5 if water and settings.surface == "auto" else 0.0
    texels *= count_sheets(sizes)
    over = _CASTING + _CAST * texels * casters + min(_WAYS, _WAY * texels) if casters else 0.0
    meshes = _TRIANGLE * max(water, finer) + _RECEIVER * receivers
    return _BASE + _TEXEL * texels**_POWER + meshes + over


def count_workers(wanted, frames, each):
    """How many workers to start at most for so many frames: `wanted`, or where that is 0, one for each core as far as
    `each` bytes for each fit into the memory that is free."""
    fit = max(1, int(_SHARE * free_memory() // each))
    return max(1, min(frames, wanted or min(cores(), fit)))


def cores():
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def free_memory():
    """Bytes of memory that processes can have without swapping; all of the machine's, where the system does not say."""
    if sys.platform == "win32":
        return _free_on_windows()
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        (line,) = (line for line in lines if line.startswith("MemAvailable:"))
        return min(1024 * int(line.split()[1]), _left_in_group())
    except (OSError, ValueError):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _left_in_group():
    """Bytes that are left to a container, whose limit /proc/meminfo does not know; more than there is without one."""
    group = Path("/sys/fs/cgroup")
    try:
        return int((group / "memory.max").read_text()) - int((group / "memory.current").read_text())
    except (OSError, ValueError):
        return sys.maxsize


def _free_on_windows():
    import ctypes

    class Status(ctypes.Structure):
        _fields_ = [("length", ctypes.c_ulong), ("load", ctypes.c_ulong)] + [
            (name, ctypes.c_ulonglong)
            for name in ("total", "free", "total_page", "free_page", "total_virtual", "free_virtual", "extended")
        ]

    status = Status()
    status.length = ctypes.sizeof(status)
    ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))
    return status.free
