"""What the classes compute, against exact answers and other packages."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import echolot
import numpy as np
import pytest
from echolot import metrics


def test_landmarks_find_the_pose_from_nowhere(drive: echolot.Recording, landmarks: echolot.EchoMap) -> None:
    found = echolot.localize(drive, landmarks, start="unknown")
    assert found.scores is not None and drive.truth is not None
    true = np.array([drive.truth.at(t) for t in found.t])
    errors = np.hypot(*(found.poses - true)[:, :2].T)
    assert found.sure.mean() > 0.8
    assert errors[found.sure].max() < 0.03
    assert np.isclose(metrics.ape(found.trajectory, drive.truth)["mean"], found.scores["mae_m"], atol=2e-6)
    assert found.covariance.shape == (len(found), 3, 3)
    assert np.all(np.linalg.eigvalsh(found.covariance) > 0)
    latest_t, latest = found.latest
    assert np.all(latest_t > found.t) and latest.shape == found.poses.shape


def test_no_map_is_needed(drive: echolot.Recording) -> None:
    found = echolot.slam(drive, progress=False)
    assert found.scores is not None and found.scores["mae_m"] < 0.03
    assert found.map is not None and found.map.kind == "landmarks"
    assert found.wheel_errors is not None and abs(found.wheel_errors[0] + 0.01) < 0.003
    walls = [landmark for landmark in found.map.landmarks if landmark["kind"] == "wall"]
    assert len(walls) >= 3 and all(np.shape(wall["ends"]) == (2, 2) for wall in walls)


def test_images_find_the_pose(drive: echolot.Recording, images: echolot.EchoMap) -> None:
    found = echolot.localize(drive, images, seed=2)
    assert found.scores is not None and found.scores["mae_m"] < 0.1
    assert set(found.status) <= {"echoes", "slow"}
    wheels = echolot.localize(drive, images, method="odometry")
    assert wheels.scores is not None and set(wheels.status) == {"wheels"}
    assert found.scores["mae_m"] < wheels.scores["mae_m"]


def test_a_bank_finds_range_and_direction() -> None:
    parameters = echolot.Parameters()
    bank = echolot.DopplerBank(parameters)
    rng = np.random.default_rng(3)
    scene = echolot.Scene.from_dict(
        {"name": "x", "grid": {"nx": 100, "ny": 100, "dx_m": 0.005, "dt_s": 8e-6}, "waveform": {"band_hz": [0, 19e3]}}
    )
    period = scene.waveform()
    c, rate, v = 340.0, 40e3, 0.3
    middle = bank.block_length / rate / 2
    t = np.arange(bank.block_length) / rate
    grid = np.arange(8 * len(period)) / 8
    fine = np.fft.irfft(np.pad(np.fft.rfft(period), (0, 4 * len(period) - len(period) // 2)), 8 * len(period)) * 8
    for _ in range(5):
        distance, angle = rng.uniform(0.6, 3.0), rng.uniform(0.3, np.pi - 0.3)
        # The echo of a wall whose foot is at this angle from the heading, at the block's middle.
        delay = 2 * (distance - v * np.cos(angle) * (t - middle)) / (c + v * np.cos(angle))
        echo = np.interp((t - delay) * rate % len(period), np.append(grid, len(period)), np.append(fine, fine[0]))
        heard = bank.measure(echo.astype(np.float32), v)
        direction, place = np.unravel_index(heard.argmax(), heard.shape)
        assert abs(bank.ranges[place] - distance) < 0.01
        assert abs(np.cos(bank.angles[direction]) - np.cos(angle)) < 0.12
    assert heard.shape == (len(bank.angles), len(bank.ranges))
    assert np.isclose(bank.excess(v, 0), -2 * v / (c + v))


def test_views_are_not_copied(drive: echolot.Recording, images: echolot.EchoMap) -> None:
    assert np.shares_memory(drive.signal, drive.signal)
    assert images.intensity is not None and np.shares_memory(images.intensity, images.intensity)
    signal = drive.signal
    kept = signal.copy()
    del drive
    assert np.array_equal(signal, kept)


def test_recordings_from_arrays_are_the_recordings(drive: echolot.Recording, landmarks: echolot.EchoMap) -> None:
    parts = drive.to_dict()
    made = echolot.Recording.from_arrays(
        parts["signal"],
        parts["odometry"],
        parts["meta"],
        truth=echolot.Trajectory(parts["truth"]["t"], parts["truth"]["poses"]),
    )
    assert np.array_equal(
        echolot.localize(made, landmarks).poses, echolot.localize(drive, landmarks).poses
    )
    assert echolot.Parameters.of_recording(made).to_dict()["code_length"] == 1023


def test_xarray_has_the_axes(drive: echolot.Recording) -> None:
    pytest.importorskip("xarray")
    data = drive.to_xarray()
    assert np.array_equal(data["signal"].values, drive.signal)
    assert np.isclose(float(data["time"][1]), 1 / drive.sample_rate)
    assert data["x"].dims == ("truth_time",) and data["speed"].attrs["units"] == "m/s"


def test_echoes_of_a_shoebox_come_when_pyroomacoustics_says() -> None:
    pra = pytest.importorskip("pyroomacoustics")
    for size, source, ear in (
        ([1.6, 1.2], [0.5, 0.4], [1.1, 0.8]),
        ([1.1, 1.4], [0.3, 1.0], [0.8, 0.35]),
    ):
        room = pra.ShoeBox(size, fs=200000, max_order=2)
        room.add_source(source)
        room.add_microphone(ear)
        room.image_source_model()
        scene = echolot.interchange.scene_of_shoebox(room)
        field = echolot.Field(scene)
        t = field.dt * np.arange(1, int(0.011 / field.dt))
        width, middle = 5e-5, 2e-4
        pulse = 1e-3 * (1 - 2 * ((t - middle) / width) ** 2) * np.exp(-(((t - middle) / width) ** 2))
        inside = np.array([0.4, 0.4])
        heard = field.run(pulse, np.array(source) + inside, np.array(ear) + inside)
        # In two dimensions every arrival drags a tail, the same for all: take the direct one's away from each.
        near = np.hypot(*(np.array(source) - ear))
        alone = echolot.Field(open_air(scene)).run(pulse, np.array(source) + inside, np.array(ear) + inside)
        echoes = heard - alone
        distances = np.sort(np.hypot(*(room.sources[0].images[:2].T - np.array(ear)).T))
        assert np.isclose(distances[0], near)
        loud = np.abs(alone).max()
        template = alone[int((near / room.c) / field.dt) : int((near / room.c + 4e-4) / field.dt)]
        correlation = np.correlate(echoes, template / np.linalg.norm(template) ** 2, mode="valid")
        for distance in distances[1:5]:
            place = (distance - near) / room.c / field.dt + near / room.c / field.dt
            around = correlation[int(place) - 6 : int(place) + 7]
            peak = int(place) - 6 + around.argmax()
            assert abs(peak - place) < 3, (distance, peak, place)
            assert around.max() > 0.3 * np.sqrt(near / distance), (distance, around.max(), loud)


def open_air(scene: echolot.Scene) -> echolot.Scene:
    return echolot.Scene.from_dict(scene.to_dict() | {"walls": []})


def test_errors_are_those_of_evo(tmp_path: Path) -> None:
    program = shutil.which("evo_ape")
    rng = np.random.default_rng(9)
    t = np.sort(rng.uniform(0, 20, 300))
    truth = np.stack([np.sin(0.4 * t) + 0.1 * t, np.cos(0.3 * t), 0.2 * t], axis=1)
    truth[:, 2] = (truth[:, 2] + np.pi) % (2 * np.pi) - np.pi
    off = truth + np.stack([0.02 * np.sin(2 * t) + 0.1, 0.03 * np.cos(t), 0.01 * np.sin(t)], axis=1)
    ours, theirs = echolot.Trajectory(t, off), echolot.Trajectory(t, truth)
    # The definition, by hand.
    distance = np.hypot(*(off - truth)[:, :2].T)
    assert np.isclose(metrics.ape(ours, theirs)["rmse"], np.sqrt(np.mean(distance**2)))
    if program is None:
        pytest.skip("evo is not installed; the definitions were checked by hand")
    ours.save(tmp_path / "ours.tum")
    theirs.save(tmp_path / "theirs.tum")
    for words, mine in ((["--align"], metrics.ape(ours, theirs, align=True)), ([], metrics.ape(ours, theirs))):
        told = subprocess.run(
            [program, "tum", tmp_path / "theirs.tum", tmp_path / "ours.tum", *words],
            check=True, capture_output=True, text=True,
        ).stdout
        numbers = {line.split()[0]: float(line.split()[1]) for line in told.splitlines() if len(line.split()) == 2}
        for name in ("rmse", "mean", "median", "std", "min", "max"):
            assert np.isclose(numbers[name], mine[name], atol=2e-6), (name, words)
