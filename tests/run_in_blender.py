"""Run the tests inside Blender itself, with Blender's own Python and its own numpy:

    blender -b --factory-startup -P tests/run_in_blender.py -- [pytest's words]

What the tests need and Blender lacks goes into a folder of the working tree, .venv-<Blender's version>-app, by pip.
Without words all tests run. The exit code is pytest's.
"""

import os
import subprocess
import sys
from pathlib import Path

import bpy

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / f".venv-{bpy.app.version_string.split()[0]}-app"
PACKAGES = "pytest>=8", "hypothesis", "OpenEXR", "ruff==0.17.6", "matplotlib", "embreex==4.4.0.post1"


def main():
    """Install, hand over to pytest, and leave with its exit code."""
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    if not (FOLDER / "pytest").is_dir():
        pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
        if subprocess.run([*pip, "install", "--target", str(FOLDER), *PACKAGES], check=False).returncode:
            print(f"pip could not install {', '.join(PACKAGES)} into {FOLDER}; its message is above.", file=sys.stderr)
            return 1
    # Last, so that what Blender brings comes first; subprocesses of the tests find it too.
    sys.path.append(str(FOLDER))
    os.environ["PYTHONPATH"] = str(FOLDER)
    os.chdir(ROOT)
    import pytest

    return int(pytest.main(["-p", "no:cacheprovider", *words]))


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)  # Blender gives the exit code of a script only with options that its versions spell differently
