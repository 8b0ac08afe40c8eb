"""Bad input gets one error in the library's words, before anything is computed; nothing is lost."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import echolot
import numpy as np
import pytest


def open_air(**fields: object) -> dict[str, object]:
    own: dict[str, object] = {
        "name": "open air",
        "grid": {"nx": 160, "ny": 160, "dx_m": 0.005, "dt_s": 8e-6},
        "paths": {
            "rest": {
                "start": {"x_m": 0.4, "y_m": 0.4, "heading_rad": 0},
                "legs": [{"duration_s": 60.0, "v_mps": 0.0, "omega_radps": 0}],
            }
        },
    }
    return own | fields


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: echolot.Scene.from_dict({"name": "x"}), "grid"),
        (lambda: echolot.Scene.from_dict(open_air(medium={"c_mps": -340})), "c_mps"),
        (lambda: echolot.Scene.from_dict(open_air(layers=3)), "layers"),
        (lambda: echolot.Scene.from_dict(open_air(layer_cells=float("nan"))), "JSON"),
        (lambda: echolot.Scene.random("hall", seed=1), "kind"),
        (lambda: echolot.Parameters(period=4), "period"),
        (lambda: echolot.Parameters(periods=1000), "periods"),
        (lambda: echolot.Trajectory([0, 1], np.zeros((3, 3))), "poses"),
        (lambda: echolot.Trajectory([1, 0], np.zeros((2, 3))), "order"),
        (lambda: echolot.Trajectory(["0", "x"], np.zeros((2, 3))), "t"),
        (lambda: echolot.transmit(carrier=1.0), "carrier"),
        (lambda: echolot.transmit(code=100), "code"),
        (lambda: echolot.transmit(-1.0), "seconds"),
        (lambda: echolot.Study.from_dict({"name": "x", "about": "x", "scenes": [], "methods": []}), "methods"),
        (lambda: echolot.simulate(echolot.Scene.from_dict(open_air()), "elsewhere"), "elsewhere"),
        (lambda: echolot.simulate(echolot.Scene.from_dict(open_air()), "rest", engine="magic"), "engine"),
        (lambda: echolot.simulate(echolot.Scene.from_dict(open_air()), "rest", image_order=2), "image_order"),
        (lambda: echolot.simulate(echolot.Scene.from_dict(open_air()), "rest", absorption=True), "absorption"),
        (lambda: echolot.simulate(echolot.Scene.from_dict(open_air()), "rest", odometry_bias=np.inf), "odometry_bias"),
        (lambda: echolot.simulate(echolot.Scene.from_dict(open_air()), "rest", scheme="m99"), "scheme"),
    ],
)
def test_values_that_cannot_be(call: Callable[[], object], words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_files_that_are_not_there(tmp_path: Path, drive: echolot.Recording) -> None:
    for call in (
        lambda: echolot.Scene.load(tmp_path / "scene.json"),
        lambda: echolot.EchoMap.load(tmp_path / "map"),
        lambda: echolot.Trajectory.load(tmp_path / "a.tum"),
        lambda: echolot.Study.load(tmp_path / "study.json"),
    ):
        with pytest.raises(FileNotFoundError, match=str(tmp_path)):
            call()
    with pytest.raises(ValueError, match="not a folder"):
        echolot.Recording.load(tmp_path / "recording")


def test_nobody_elses_file_is_replaced(tmp_path: Path, drive: echolot.Recording, room: echolot.Scene) -> None:
    (tmp_path / "own").mkdir()
    note = tmp_path / "own" / "notes.txt"
    note.write_text("precious")
    with pytest.raises(ValueError, match=r"notes\.txt"):
        drive.save(tmp_path / "own")
    assert note.read_text() == "precious"
    track = tmp_path / "a.tum"
    track.write_text("0 0 0 0 0 0 0 1\n")
    assert drive.truth is not None
    with pytest.raises(ValueError, match="force"):
        drive.truth.save(track)
    drive.truth.save(track, force=True)
    room.save(tmp_path / "scene.json")
    room.save(tmp_path / "scene.json")
    with pytest.raises(ValueError, match="force"):
        echolot.Scene.random("open", 1).save(tmp_path / "scene.json")


def test_what_does_not_belong_together(
    drive: echolot.Recording, landmarks: echolot.EchoMap, images: echolot.EchoMap
) -> None:
    for call, words in (
        (lambda: echolot.localize(drive, images, method="landmarks"), "method"),
        (lambda: echolot.localize(drive, landmarks, method="doppler"), "method"),
        (lambda: echolot.localize(drive, images, start="unknown"), "start"),
        (lambda: echolot.localize(drive, landmarks, start="somewhere"), "start"),
        (lambda: echolot.localize(drive, landmarks, particles=100), "particles"),
        (lambda: echolot.Localizer(images, start="unknown"), "start"),
        (lambda: echolot.Localizer(images, start=(0.0, 0.0, np.nan)), "start"),
        (lambda: echolot.EchoMap.build([]), "drive"),
        (lambda: echolot.EchoMap.build([drive], method="grid"), "method"),
    ):
        with pytest.raises(ValueError, match=words):
            call()
    stream = echolot.Localizer(images, start=(1.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="samples"):
        stream.step(np.zeros(17), 0.1, 0.0)
    with pytest.raises(ValueError, match="odometry"):
        stream.run(np.zeros(3 * stream.samples_per_period), np.zeros((2, 2)))
    with pytest.raises(ValueError, match="m/s"):
        stream.step(np.zeros(stream.samples_per_period), 90.0, 0.0)


def test_a_dead_microphone_is_refused(drive: echolot.Recording, images: echolot.EchoMap) -> None:
    dead = echolot.Recording.from_arrays(np.zeros_like(drive.signal), drive.odometry, drive.meta, truth=drive.truth)
    with pytest.raises(ValueError, match="microphone was dead"):
        echolot.localize(dead, images)
    with pytest.raises(ValueError, match="microphone was dead"):
        echolot.slam(dead, progress=False)
    rng = np.random.default_rng(5)
    noise = echolot.Recording.from_arrays(
        rng.standard_normal(len(drive.signal)), drive.odometry, drive.meta, truth=drive.truth
    )
    with pytest.raises(ValueError, match="holds no echoes"):
        echolot.localize(noise, images)


def test_doubts_are_warnings(drive: echolot.Recording, images: echolot.EchoMap) -> None:
    meta = drive.meta
    meta["speed_of_sound_mps"] *= 1.01
    colder = echolot.Recording.from_arrays(drive.signal, drive.odometry, meta, truth=drive.truth)
    with pytest.warns(UserWarning, match="speed_of_sound"):
        echolot.localize(colder, images)


def test_arrays_of_recordings_cannot_be_changed(drive: echolot.Recording) -> None:
    with pytest.raises(ValueError, match="read-only"):
        drive.signal[0] = 1.0
    with pytest.raises(ValueError):
        drive.signal.setflags(write=True)


def test_ctrl_c_ends_a_simulation_within_a_second() -> None:
    scene = echolot.Scene.from_dict(open_air())
    pressed = []

    def press() -> None:
        pressed.append(time.monotonic())
        signal.raise_signal(signal.SIGINT)

    # The main thread must get the signal, as from a terminal.
    timer = threading.Timer(0.7, press)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        echolot.simulate(scene, "rest", progress=False)
    assert time.monotonic() - pressed[0] < 1.0
    # Nothing is left over: the next one runs.
    short = open_air()
    short["paths"]["rest"]["legs"][0]["duration_s"] = 0.12  # type: ignore[index]
    assert len(echolot.simulate(echolot.Scene.from_dict(short), "rest", progress=False).signal) == 4800


def test_a_study_goes_on_after_ctrl_c(tmp_path: Path) -> None:
    study = echolot.Study.from_dict(
        {
            "name": "interrupted",
            "about": "Is anything lost?",
            "scenes": [{"random": "room", "seeds": [1, 3]}],
            "methods": ["landmarks"],
            "set": {"field.engine": "image-source", "field.image_order": 3},
        }
    )
    timer = threading.Timer(1.0, lambda: signal.raise_signal(signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        study.run(tmp_path / "one", figures=False)
    # An error that is none of the user's interruptions leaves no trace either.
    with pytest.raises(ValueError, match="no such cell|cell"):
        study.run(tmp_path / "one", only=["nowhere=1"], figures=False)
    summary = study.run(tmp_path / "one", figures=False)
    assert summary["cells"] == study.run(tmp_path / "other", figures=False)["cells"]


def test_an_error_of_the_callback_comes_back() -> None:
    def trouble(done: int, of: int) -> None:
        raise RuntimeError("trouble")

    with pytest.raises(RuntimeError, match="trouble"):
        echolot.simulate(echolot.Scene.from_dict(open_air()), "rest", progress=trouble)


def test_other_threads_run_during_a_simulation() -> None:
    short = open_air()
    short["paths"]["rest"]["legs"][0]["duration_s"] = 1.0  # type: ignore[index]
    counts = [0]
    done = threading.Event()

    def count() -> None:
        while not done.wait(0.01):
            counts[0] += 1

    beside = threading.Thread(target=count)
    beside.start()
    echolot.simulate(echolot.Scene.from_dict(short), "rest", progress=False)
    done.set()
    beside.join()
    assert counts[0] > 5
