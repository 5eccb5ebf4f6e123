"""The entry of a worker process: solves what comes by one pipe, answers by another, and knows no Blender.

Run by its path with `-I`, so that nothing of the user's environment gets in. The first message says where packages are
and by which name this one goes: in Blender that is bl_ext.<repository>.dapple, which only Blender can import.

A thread reads ahead. So the parent never waits while this process is busy, and where the parent ends, however it does,
this process ends at once, in the midst of a frame too.
"""

import importlib
import importlib.util
import os
import pickle
import queue
import signal
import sys
import threading
import traceback
import types
from multiprocessing import connection


def main(arguments):
    """Serve the parent behind the pipes of these numbers until it closes them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    kind = connection.PipeConnection if sys.platform == "win32" else connection.Connection
    jobs = kind(int(arguments[0]), writable=False)
    answers = kind(int(arguments[1]), readable=False)
    waiting = queue.SimpleQueue()
    threading.Thread(target=read_ahead, args=(jobs, waiting), daemon=True).start()
    solver = load_solver(pickle.loads(waiting.get()))
    while True:
        for answer in solver.answers(pickle.loads(waiting.get())):
            answers.send_bytes(pickle.dumps(answer, pickle.HIGHEST_PROTOCOL))


def read_ahead(jobs, waiting):
    """Put message after message in the queue; end the process where there will be no more."""
    try:
        while True:
            waiting.put(jobs.recv_bytes())
    except (EOFError, OSError):
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        os._exit(1)


def load_solver(hello):
    """A Solver of the package `name` in the folder `root`, with the parent's `path`."""
    sys.path[:] = hello["path"]
    *parents, _ = parts = hello["name"].split(".")
    for k in range(len(parents)):
        name = ".".join(parts[: k + 1])
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].__path__ = []
    place = os.path.join(hello["root"], "__init__.py")
    spec = importlib.util.spec_from_file_location(hello["name"], place, submodule_search_locations=[hello["root"]])
    package = sys.modules[hello["name"]] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    return importlib.import_module(hello["name"] + ".operators.bake.solver").Solver()


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except OSError:  # the parent is gone while it is being answered
        os._exit(0)
