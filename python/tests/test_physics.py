"""What the classes compute, against exact answers and other packages."""

from __future__ import annotations

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
