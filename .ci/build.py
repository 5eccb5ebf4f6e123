"""Make the extension's zips in dist/, one a platform, with Blender's own builder; let Blender validate each.

Runs in an environment that holds the bpy wheel; Blender itself is not started. The builder takes the working tree as it
is, less what the manifest excludes.
"""

import argparse
import importlib.util
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def find_builder():
    """The path of Blender's command line tool for extensions."""
    blender = Path(importlib.util.find_spec("bpy").origin).parent
    (tool,) = blender.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")
    return tool


def download_command(name, folder):
    """The pip command that fetches the wheel of this file name, whatever platform it is for."""
    package, version, python, abi, platform = name.removesuffix(".whl").split("-")
    return [
        *(sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"),
        *("--only-binary=:all:", "--dest", str(folder), "--platform", platform.split(".")[-1]),
        *("--python-version", python.removeprefix("cp"), "--abi", abi, f"{package}=={version}"),
    ]


def download_wheels(manifest, folder):
    """Put every wheel that the manifest lists into the folder; those that are there stay."""
    for wheel in manifest["wheels"]:
        path = folder / Path(wheel).name
        if not path.exists():
            subprocess.run(download_command(path.name, folder), check=False)
        if not path.exists():
            sys.exit(f"dapple: {path.name} could not be downloaded")


def build(source, dist):
    """Build and validate the zips; returns Blender's worst exit code."""
    dist.mkdir(exist_ok=True)
    for old in dist.glob("dapple-*.zip"):
        old.unlink()
    command = ["build", "--source-dir", str(source), "--output-dir", str(dist), "--split-platforms"]
    results = [subprocess.run([sys.executable, str(find_builder()), *command], check=False).returncode]
    for path in sorted(dist.glob("dapple-*.zip")):
        print(f"{path.relative_to(source)}: {path.stat().st_size / 1e6:.1f} MB", flush=True)
        results.append(subprocess.run([sys.executable, str(find_builder()), "validate", str(path)]).returncode)
    return max(results)


def main():
    """Download, build, validate."""
    argparse.ArgumentParser("dapple build", description=__doc__.partition("\n")[0]).parse_args()
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text())
    download_wheels(manifest, ROOT / "wheels")
    return build(ROOT, ROOT / "dist")


if __name__ == "__main__":
    sys.exit(main())
