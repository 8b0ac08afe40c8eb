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
ROOT = Path(__file__).resolve().parents[2]
ROBOT = ROOT / "experiments" / "robots" / "site.json"
EXAMPLE = ROOT / "examples" / "site_robot"


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
        (13, {"robot": ROBOT}, ["--robot", ROBOT]),
        (14, {"free_field": True}, ["--free-field"]),
    ],
)
def test_simulate_by_image_sources(
    program: Program, tmp_path: Path, seed: int, options: dict[str, Any], words: list[Any]
) -> None:
    scene = echolot.Scene.random("open", seed=seed)
    scene.save(tmp_path / "scene.json")
    arguments = ["--path", "mapping", "--engine", "image-source", *words]
    program("simulate", tmp_path / "scene.json", *arguments, "-o", tmp_path / "told")
    recording = echolot.simulate(scene, "mapping", engine="image-source", progress=False, **options)
    recording.save(tmp_path / "made")
    assert files(tmp_path / "made") == files(tmp_path / "told")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, []),
        ({"free_field": True, "scheme": "m13"}, ["--free-field", "--scheme", "m13"]),
        ({"walls": "cut_cells", "spread": "bilinear"}, ["--walls", "cut-cells", "--spread", "bilinear"]),
        ({"whole_domain": True, "scheme": "slf"}, ["--whole-domain", "--scheme", "slf"]),
        ({"robot": ROBOT}, ["--robot", ROBOT]),
    ],
)
def test_simulate_on_the_field(program: Program, tmp_path: Path, options: dict[str, Any], words: list[Any]) -> None:
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
    arguments = ["--path", "drive", "-o", tmp_path / "told", "--threads", "1", *words]
    program("simulate", tmp_path / "scene.json", *arguments)
    told: list[tuple[int, int]] = []
    scene = echolot.Scene.from_dict(fields)
    recording = echolot.simulate(scene, "drive", progress=lambda done, of: told.append((done, of)), **options)
    recording.save(tmp_path / "made")
    assert files(tmp_path / "made") == files(tmp_path / "told")
    assert told[-1][0] == told[-1][1] > 0
    # What a robot records has clocks to be found, and this one hardly moves.
    if "robot" not in options:
        again = echolot.Recording.load(tmp_path / "told")
        assert np.array_equal(again.signal, recording.signal)


def test_a_sound_cards_recording_with_numbers_given(program: Program, tmp_path: Path) -> None:
    told = [line for line in echolot.Recording.load(EXAMPLE / "drive").notes if "clock of the truth" in line]
    assert told, "the example's clocks are found"
    program("map", EXAMPLE / "mapping", "-o", tmp_path / "map")
    words = ["--channel", "1", "--late", "86.9", "--drift", "-30", "--odometry-clock", "731.2", "--truth-clock", "1716249600.4"]
    arguments = ["--map", tmp_path / "map", "-o", tmp_path / "told.tum", "--particles", "100"]
    program("localize", EXAMPLE / "drive", *arguments, *words)
    recording = echolot.Recording.load(
        EXAMPLE / "drive", channel=1, late=0.0869, drift=-30.0, odometry_clock=731.2, truth_clock=1716249600.4
    )
    found = echolot.localize(recording, echolot.EchoMap.load(tmp_path / "map"), particles=100)
    found.save(tmp_path / "made.tum")
    assert (tmp_path / "made.tum").read_bytes() == (tmp_path / "told.tum").read_bytes()


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


def test_a_cell_of_a_study_by_another_engine(program: Program, tmp_path: Path) -> None:
    study = {
        "name": "cells",
        "about": "Does the package take the options of the program?",
        "scenes": [{"random": "room", "seeds": [5, 5]}],
        "methods": ["landmarks"],
        "vary": [{"localizer.periods": [2, 3]}],
    }
    (tmp_path / "study.json").write_text(json.dumps(study))
    words = ["--only", "localizer.periods=3", "--engine", "image-source", "--image-order", "1", "--no-figures"]
    program("run", tmp_path / "study.json", "--results", tmp_path / "told", *words)
    own = echolot.Study.from_dict(study, tmp_path)
    assert len(own.cells) == 2
    only = ["localizer.periods=3"]
    summary = own.run(tmp_path / "made", only=only, engine="image-source", image_order=1, figures=False)
    told = json.loads((tmp_path / "told/cells/summary.json").read_text())
    assert summary["cells"] == told["cells"] and len(summary["cells"]) == 1
    with pytest.raises(ValueError, match="localizer.periods=7"):
        own.run(tmp_path / "made", only=["localizer.periods=7"], engine="image-source")
