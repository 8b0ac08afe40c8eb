"""README, doc strings, examples, notebooks and type stubs say what is true."""

from __future__ import annotations

import doctest
import os
import re
import subprocess
import sys
from pathlib import Path

import echolot
import pytest

PACKAGE = Path(__file__).resolve().parents[1]
MARKDOWN = [PACKAGE / "README.md", PACKAGE.parent / "README.md"]


def run(arguments: list[str], folder: Path) -> str:
    environment = os.environ | {"MPLBACKEND": "Agg"}
    done = subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("file", MARKDOWN, ids=["package", "project"])
def test_the_examples_of_readme_run_as_printed(file: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", file.read_text(), re.MULTILINE | re.DOTALL)
    assert blocks, file
    for block in blocks:
        run(["-c", block], tmp_path)


@pytest.mark.parametrize("module", [echolot, echolot.metrics], ids=lambda module: module.__name__)
def test_doc_strings_run(module: object) -> None:
    result = doctest.testmod(module)  # type: ignore[arg-type]
    assert result.attempted > 0 and result.failed == 0


@pytest.mark.parametrize("example", sorted((PACKAGE / "examples").glob("*.py")), ids=lambda path: path.stem)
def test_examples_run(example: Path, tmp_path: Path) -> None:
    told = run([str(example)], tmp_path)
    pictures = list(tmp_path.glob("*.png"))
    assert pictures and all(picture.name in told for picture in pictures)


def test_everything_has_a_doc_string() -> None:
    for name in echolot.__all__:
        thing = getattr(echolot, name)
        assert name == "__version__" or thing.__doc__, name
        if isinstance(thing, type):
            for member, value in vars(thing).items():
                assert member.startswith("_") or value.__doc__, f"{name}.{member}"


@pytest.mark.parametrize("notebook", sorted((PACKAGE / "notebooks").glob("*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_run(notebook: Path, tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    content = nbformat.read(notebook, as_version=4)
    client = nbclient.NotebookClient(content, timeout=240, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()


def test_types_are_consistent() -> None:
    pytest.importorskip("mypy")
    run(["-m", "mypy"], PACKAGE)


def test_the_stub_describes_the_compiled_module(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    run(["-m", "mypy.stubtest", "echolot._echolot"], tmp_path)
