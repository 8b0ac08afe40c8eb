"""The package gives the bytes of the command line."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import echolot
import numpy as np
import pytest

Program = Callable[..., str]


def files(folder: Path) -> dict[str, bytes]:
    """Contents by name, but for the manifest's digests and how long it took."""
    found = {}
    for path in sorted(folder.iterdir()):
        content = path.read_bytes()
        if path.name == "recording.json":
            fields = json.loads(content)
            fields["provenance"].pop("seconds")
            content = json.dumps(fields).encode()
        if path.name != "manifest.json":
            found[path.name] = content
    return found


@pytest.mark.parametrize(
    ("seed", "options", "words"),
    [
        (3, {}, []),
        (11, {"image_order": 1, "odometry_bias": -0.004}, ["--image-order", "1", "--odometry-bias", "-0.004"]),
        (12, {"absorption": True, "with_direct": True}, ["--absorption", "--with-direct"]),
    ],
)
def test_simulate_by_image_sources(
    program: Program, tmp_path: Path, seed: int, options: dict[str, Any], words: list[str]
) -> None:
    scene = echolot.Scene.random("open", seed=seed)
    scene.save(tmp_path / "scene.json")
    arguments = ["--path", "mapping", "--engine", "image-source", *words]
    program("simulate", tmp_path / "scene.json", *arguments, "-o", tmp_path / "told")
    recording = echolot.simulate(scene, "mapping", engine="image-source", progress=False, **options)
    recording.save(tmp_path / "made")
    assert files(tmp_path / "made") == files(tmp_path / "told")


def test_simulate_on_the_field(program: Program, tmp_path: Path) -> None:
    fields = {
        "name": "a wall in warm air",
        "medium": {"temperature_degc": 23.5, "relative_humidity_percent": 61},
        "grid": {"nx": 264, "ny": 211, "dx_m": 0.005, "dt_s": 7.1e-6},
        "walls": [{"points_m": [[0.25, 0.8], [0.9, 0.86]], "thickness_m": 0.02}],
        "waveform": {"code_length": 255},
        "paths": {
            "drive": {
                "start": {"x_m": 0.6, "y_m": 0.4, "heading_rad": 0.2},
                "legs": [{"duration_s": 0.2, "v_mps": 0.2, "omega_radps": 0.5}],
            }
        },
    }
    (tmp_path / "scene.json").write_text(json.dumps(fields))
    program("simulate", tmp_path / "scene.json", "--path", "drive", "-o", tmp_path / "told", "--threads", "1")
    told: list[tuple[int, int]] = []
    scene = echolot.Scene.from_dict(fields)
    recording = echolot.simulate(scene, "drive", progress=lambda done, of: told.append((done, of)))
    recording.save(tmp_path / "made")
    assert files(tmp_path / "made") == files(tmp_path / "told")
    assert told[-1][0] == told[-1][1] > 0
    again = echolot.Recording.load(tmp_path / "told")
    assert np.array_equal(again.signal, recording.signal)


@pytest.mark.parametrize("method", ["images", "landmarks"])
def test_maps_and_poses(
    program: Program,
    tmp_path: Path,
    mapping: echolot.Recording,
    drive: echolot.Recording,
    method: str,
) -> None:
    mapping.save(tmp_path / "mapping")
    drive.save(tmp_path / "drive")
    program("map", tmp_path / "mapping", "--method", method, "-o", tmp_path / "told")
    # The same input: logs in files have as many digits as anyone needs, and no more.
    own = echolot.EchoMap.build([echolot.Recording.load(tmp_path / "mapping")], method=method)
    own.save(tmp_path / "made")
    assert files(tmp_path / "made") == files(tmp_path / "told")
    words = ["--method", "landmarks"] if method == "landmarks" else ["--particles", "200", "--seed", "5"]
    program("localize", tmp_path / "drive", "--map", tmp_path / "told", *words, "-o", tmp_path / "told.tum")
    read = echolot.Recording.load(tmp_path / "drive")
    options: dict[str, Any] = {} if method == "landmarks" else {"particles": 200, "seed": 5}
    for known in (own, echolot.EchoMap.load(tmp_path / "told")):
        found = echolot.localize(read, known, **options)
        found.save(tmp_path / "made.tum")
        assert (tmp_path / "made.tum").read_bytes() == (tmp_path / "told.tum").read_bytes()


def test_slam(program: Program, tmp_path: Path, drive: echolot.Recording) -> None:
    drive.save(tmp_path / "drive")
    program("slam", tmp_path / "drive", "-o", tmp_path / "told.tum", "--map-out", tmp_path / "told")
    found = echolot.slam(echolot.Recording.load(tmp_path / "drive"), progress=False)
    found.save(tmp_path / "made.tum")
    assert (tmp_path / "made.tum").read_bytes() == (tmp_path / "told.tum").read_bytes()
    assert found.map is not None
    found.map.save(tmp_path / "made")
    assert files(tmp_path / "made") == files(tmp_path / "told")


def test_a_stream_gives_the_poses_of_the_whole(
    drive: echolot.Recording, landmarks: echolot.EchoMap, images: echolot.EchoMap
) -> None:
    start = drive.start
    assert start is not None
    cases: list[tuple[echolot.EchoMap, dict[str, Any]]] = [(landmarks, {}), (images, {"seed": 3})]
    for own, options in cases:
        stream = echolot.Localizer(own, start=start, **options)
        odometry, length = drive.odometry_per_period(), stream.samples_per_period
        one_by_one = [
            stream.step(drive.signal[k * length : (k + 1) * length], *odometry[k]) for k in range(len(odometry))
        ]
        whole = echolot.localize(drive, own, **options)
        estimates = [estimate for estimate in one_by_one if estimate is not None]
        assert np.array_equal([estimate.pose for estimate in estimates], whole.poses)
        assert np.array_equal([estimate.covariance for estimate in estimates], whole.covariance)
        at_once = echolot.Localizer(own, start=start, **options).run(
            drive.signal[: len(odometry) * length], odometry
        )
        assert [None if e is None else e.pose for e in at_once] == [None if e is None else e.pose for e in one_by_one]


def test_transmit(program: Program, tmp_path: Path) -> None:
    words = ["--seconds", "1", "--rate", "44100", "--code", "511", "--level", "-3"]
    program("transmit", "-o", tmp_path / "told.wav", *words)
    sound, description = echolot.transmit(1.0, rate=44100, code=511, level=-3.0, file=tmp_path / "made.wav")
    assert (tmp_path / "made.wav").read_bytes() == (tmp_path / "told.wav").read_bytes()
    assert (tmp_path / "made.json").read_bytes() == (tmp_path / "told.json").read_bytes()
    assert np.isclose(np.abs(sound).max(), 10 ** (-3 / 20))
    assert len(sound) == round(description["periods"] * description["period_s"] * 44100)


def test_study(program: Program, tmp_path: Path) -> None:
    study = {
        "name": "python",
        "about": "Does the package run what the program runs?",
        "scenes": [{"random": "room", "seeds": [4, 4]}],
        "methods": ["odometry", "landmarks"],
        "set": {"field.engine": "image-source", "field.image_order": 2},
        "figures": [{"kind": "bars"}],
    }
    (tmp_path / "study.json").write_text(json.dumps(study))
    program("run", tmp_path / "study.json", "--results", tmp_path / "told", "--cache", tmp_path / "cache")
    own = echolot.Study.load(tmp_path / "study.json")
    summary = own.run(tmp_path / "made", cache=tmp_path / "cache")
    told = json.loads((tmp_path / "told" / "python" / "summary.json").read_text())
    assert summary["cells"] == told["cells"]
    of = "data/trials.csv"
    assert (tmp_path / "made/python" / of).read_bytes() == (tmp_path / "told/python" / of).read_bytes()
