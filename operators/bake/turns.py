"""Two bakes in one folder, on one machine or on two: they change its record in turns, and clear up behind each other.

A turn is an advisory lock of the system, which falls with the process that holds it, however that ends.
"""

from __future__ import annotations

import contextlib
import os
import platform
import time
import zlib
from pathlib import Path

from ..errors import DappleError

_PATIENCE = 20.0  # s; a turn takes some ms
_HOST = f"{zlib.crc32(platform.node().encode()):08x}"
_LOCKED = "{} is held by another bake for too long; stop that one, or choose another folder."


def partial_path(path):
    """Where this process writes what will be at `path`: hidden, beside it, and no other process's."""
    return path.with_name(f".{path.stem}.{_HOST}-{os.getpid()}.partial{path.suffix}")


def clear_up(folder):
    """Remove the partial files in a folder, and in those in it, of processes of this machine that are no more."""
    for path in [*Path(folder).glob(".*.partial*"), *Path(folder).glob("*/.*.partial*")]:
        host, _, process = path.name.partition(".partial")[0].rpartition(".")[2].partition("-")
        if host == _HOST and process.isdecimal() and not _runs(int(process)):
            with contextlib.suppress(OSError):
                path.unlink()


def _runs(process):
    """Whether a process of this number runs. On Windows no file of one that runs can be removed: there, no."""
    if os.name != "posix":
        return False
    try:
        os.kill(process, 0)
    except OSError as error:
        return isinstance(error, PermissionError)
    return True


@contextlib.contextmanager
def turn(path):
    """Hold the turn to change the file at `path`; where the file system knows no locks, go without.

    Raises DappleError where another holds it for too long, OSError where the folder takes no file.
    """
    lock = path.with_name(f".{path.name}.lock")
    file = _hold(lock)
    try:
        yield
    finally:
        if os.name == "posix":
            lock.unlink(missing_ok=True)
            file.close()
        else:
            file.close()
            with contextlib.suppress(OSError):
                lock.unlink()


def _hold(lock):
    """The open file `lock`, locked."""
    until = time.monotonic() + _PATIENCE
    while True:
        file = lock.open("ab")
        if _lock(file) and _is_there(file, lock):
            return file
        file.close()
        if time.monotonic() > until:
            raise DappleError(_LOCKED.format(lock))
        time.sleep(0.01)


def _is_there(file, lock):
    """Whether an open file is still the one of its name: who had the turn before has removed it."""
    try:
        return os.name != "posix" or os.path.samestat(os.fstat(file.fileno()), os.stat(lock))
    except FileNotFoundError:
        return False


def _lock(file):
    """Lock an open file; False where another has it."""
    try:
        if os.name == "posix":
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        else:
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:  # no locks here
        return True
    return True
