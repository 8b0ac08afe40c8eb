"""What tests share: the command line's program, and one small room with its recordings."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import echolot
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def program() -> Callable[..., str]:
    """Runs ``echolot`` with arguments and returns what it prints."""
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "echolot"
    found = str(built) if built.exists() else shutil.which("echolot")
    if found is None:
        pytest.skip("the program echolot is not built: cargo build --release")

    def run(*arguments: object) -> str:
        done = subprocess.run([found, *map(str, arguments)], check=True, capture_output=True, text=True)
        return done.stdout

    return run


@pytest.fixture(scope="session")
def room() -> echolot.Scene:
    return echolot.Scene.random("room", seed=7)


@pytest.fixture(scope="session")
def mapping(room: echolot.Scene) -> echolot.Recording:
    return echolot.simulate(room, "mapping", engine="image-source", progress=False)


@pytest.fixture(scope="session")
def drive(room: echolot.Scene) -> echolot.Recording:
    return echolot.simulate(room, "localization", engine="image-source", progress=False)


@pytest.fixture(scope="session")
def landmarks(mapping: echolot.Recording) -> echolot.EchoMap:
    return echolot.EchoMap.build([mapping], method="landmarks")


@pytest.fixture(scope="session")
def images(mapping: echolot.Recording) -> echolot.EchoMap:
    return echolot.EchoMap.build([mapping])
