"""What goes to and comes from other packages, against these packages: ``pip install './python[interchange]'``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from unittest import mock

import echolot
import numpy as np
import pytest
from echolot import metrics


@pytest.mark.parametrize(("c", "rho", "dx"), [(343.2, 1.2, 0.005), (1482.0, 998.0, 2e-4)])
def test_a_field_gives_what_kwave_gives(c: float, rho: float, dx: float) -> None:
    def download(_: str, path: str) -> None:
        Path(path).write_bytes(b"")

    # Importing it fetches programs that its Python solver does not need.
    with mock.patch("urllib.request.urlretrieve", download):
        pytest.importorskip("kwave")
    from kwave.kgrid import kWaveGrid
    from kwave.kmedium import kWaveMedium
    from kwave.ksensor import kSensor
    from kwave.ksource import kSource
    from kwave.kspaceFirstOrder import kspaceFirstOrder

    size, steps, dt = (128, 110), 420, 0.4 * dx / c
    kgrid = kWaveGrid(size, (dx, dx))
    kgrid.setTime(steps, dt)
    medium = kWaveMedium(sound_speed=c, density=rho)
    mask, ears = np.zeros(size), np.zeros(size)
    mask[40, 50] = mask[70, 80] = 1
    ears[90, 50] = ears[30, 90] = ears[64, 20] = 1
    k = np.arange(steps)
    pulses = [
        gain * (1 - 2 * ((k - k0) / 15) ** 2) * np.exp(-(((k - k0) / 15) ** 2)) for gain, k0 in ((1, 50), (-0.5, 66))
    ]
    source, sensor = kSource(), kSensor(mask=ears)
    source.p_mask, source.p, source.p_mode = mask, np.stack(pulses), "additive-no-correction"
    sensor.record = ["p"]
    expected = kspaceFirstOrder(kgrid, medium, source, sensor, quiet=True)["p"]
    found = echolot.interchange.run_kwave(kgrid, medium, source, sensor)["p"]
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() < 0.02 * np.abs(expected).max()
    source.p_mode = "dirichlet"
    with pytest.raises(ValueError, match="additive"):
        echolot.interchange.run_kwave(kgrid, medium, source, sensor)


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
    program = Path(sys.executable).with_name("evo_ape")
    rng = np.random.default_rng(9)
    t = np.sort(rng.uniform(0, 20, 300))
    truth = np.stack([np.sin(0.4 * t) + 0.1 * t, np.cos(0.3 * t), 0.2 * t], axis=1)
    truth[:, 2] = (truth[:, 2] + np.pi) % (2 * np.pi) - np.pi
    off = truth + np.stack([0.02 * np.sin(2 * t) + 0.1, 0.03 * np.cos(t), 0.01 * np.sin(t)], axis=1)
    ours, theirs = echolot.Trajectory(t, off), echolot.Trajectory(t, truth)
    # The definition, by hand.
    distance = np.hypot(*(off - truth)[:, :2].T)
    assert np.isclose(metrics.ape(ours, theirs)["rmse"], np.sqrt(np.mean(distance**2)))
    if not program.exists():
        pytest.skip("evo is not installed; the definitions were checked by hand")
    ours.save(tmp_path / "ours.tum")
    theirs.save(tmp_path / "theirs.tum")
    for words, mine in ((["--align"], metrics.ape(ours, theirs, align=True)), ([], metrics.ape(ours, theirs))):
        told = subprocess.run(
            [program, "tum", tmp_path / "theirs.tum", tmp_path / "ours.tum", *words],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        names = ("rmse", "mean", "median", "std", "min", "max")
        lines = [line.split() for line in told.splitlines()]
        numbers = {line[0]: float(line[1]) for line in lines if len(line) == 2 and line[0] in names}
        assert len(numbers) == len(names)
        for name, number in numbers.items():
            assert np.isclose(number, mine[name], atol=2e-6), (name, words)
