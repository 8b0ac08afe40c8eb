"""The field by hand: against a simulation, an exact solution, and itself."""

from __future__ import annotations

from pathlib import Path

import echolot
import numpy as np
import pytest


def scene(temperature: float = 20.0, **fields: object) -> echolot.Scene:
    own: dict[str, object] = {
        "name": "by hand",
        "medium": {"temperature_degc": temperature, "relative_humidity_percent": 35},
        "grid": {"nx": 281, "ny": 230, "dx_m": 0.005, "dt_s": 7e-6},
        "walls": [{"points_m": [[0.2, 0.9], [1.1, 0.8]], "thickness_m": 0.03}],
        "paths": {
            "drive": {
                "start": {"x_m": 0.5, "y_m": 0.5, "heading_rad": 0.4},
                "legs": [{"duration_s": 0.03, "v_mps": 0.4, "omega_radps": 1.5}],
            }
        },
    }
    return echolot.Scene.from_dict(own | fields)


@pytest.mark.parametrize(
    ("scheme", "temperature"), [("slf", 3.5), ("m13", 20.0), ("o13", 11.0), ("d25", 29.0), ("iwb", 7.0)]
)
def test_one_pair_gives_the_samples_of_simulate(scheme: str, temperature: float) -> None:
    grid = {"nx": 281, "ny": 230, "dx_m": 0.005, "dt_s": 1 / 120e3}
    own = scene(temperature, scheme=scheme, grid=grid)
    recording = echolot.simulate(own, "drive", progress=False, whole_domain=True)
    steps = 3 * (len(recording.signal) - 1)
    times = own.dt * np.arange(1, steps + 1)
    drive = own.drive("drive", rate=1 / own.dt)
    places = np.array([np.interp(times, drive.t, drive.poses[:, axis]) for axis in (0, 1)]).T
    field = echolot.Field(own)
    heard = field.run(own.source_strength(times), places, places[:, None])
    # The recording is anti-aliased and decimated; below its band both are the same.
    taper = np.hanning(len(recording.signal) - 1)
    spectrum = np.fft.rfft(heard[2::3, 0] * taper)
    other = np.fft.rfft(recording.signal[1:] * taper)
    band = np.fft.rfftfreq(len(taper), 1 / recording.sample_rate)
    low = (band > 2e3) & (band < 15e3)
    error = np.abs(spectrum - other)[low].max() / np.abs(other[low]).max()
    assert error < 0.01, error
    assert field.steps == steps and np.isclose(field.time, steps * own.dt)


def test_pieces_callbacks_and_engines_change_nothing() -> None:
    own = scene()
    times = own.dt * np.arange(1, 901)
    strengths = own.source_strength(times)
    source, ears = (0.5, 0.5), [(0.8, 0.5), (0.6, 0.7)]
    whole = echolot.Field(own).run(strengths, source, ears)
    assert whole.shape == (900, 2) and whole.dtype == np.float32
    looks: list[int] = []
    pieces = echolot.Field(own, engine="reference")
    heard = [
        pieces.run(part, source, ears, callback=lambda field: looks.append(field.steps), every=100)
        for part in np.split(strengths, [1, 333])
    ]
    assert np.array_equal(np.concatenate(heard), whole)
    assert len(looks) == 0 + 3 + 5
    one = echolot.Field(own).run(strengths, source, ears[0])
    assert np.array_equal(one, whole[:, 0])
    assert echolot.Field(own).run(strengths, source).shape == (900, 0)


def test_sources_add_up() -> None:
    own = scene(14.0)
    strengths = own.source_strength(own.dt * np.arange(1, 801))
    a, b, ear = (0.4, 0.4), (0.9, 0.5), (0.7, 0.6)
    alone = [echolot.Field(own).run(strengths, place, ear) for place in (a, b)]
    both = echolot.Field(own).run(np.stack([strengths, -2 * strengths], axis=1), [a, b], ear)
    expected = alone[0] - 2 * alone[1]
    assert np.abs(both - expected).max() < 1e-4 * np.abs(expected).max() > 0


def test_pressure_is_the_field() -> None:
    own = scene(25.0, walls=[])
    field = echolot.Field(own)
    steps = 250
    t = own.dt * np.arange(1, steps + 1)
    field.run(1e-3 * np.exp(-(((t - 3e-4) / 6e-5) ** 2)), (0.7, 0.575))
    pressure = field.pressure
    assert pressure.shape == own.shape and pressure.flags.c_contiguous
    # A ring around the source, as wide as sound has come.
    iy, ix = np.indices(own.shape)
    radius = np.hypot((ix + 0.5) * own.dx - 0.7, (iy + 0.5) * own.dx - 0.575)
    front = own.speed_of_sound * (field.time - 3e-4)
    assert abs(radius[np.abs(pressure) > 0.5 * np.abs(pressure).max()].mean() - front) < 0.03
    ahead = np.abs(pressure[radius > front + 0.15]).max()
    assert ahead < 1e-3 * np.abs(pressure).max()


@pytest.mark.parametrize("engine", ["fast", "reference"])
def test_pressure_is_a_view_that_follows_the_field(engine: str) -> None:
    own = scene(14.0)
    field = echolot.Field(own, engine=engine)
    strengths = own.source_strength(own.dt * np.arange(1, 701))
    source = (0.5, 0.45)
    view = field.pressure
    assert not view.any() and not view.flags.owndata
    with pytest.raises(ValueError, match="read-only"):
        view[0, 0] = 1.0
    seen = []
    field.run(strengths[:300], source, callback=lambda now: seen.append((now.steps, view.copy())), every=100)
    assert field.pressure.base is view.base
    # The same field afresh, looked at once at each of these steps.
    for steps, pressure in [*seen, (300, view)]:
        other = echolot.Field(own)
        other.run(strengths[:steps], source)
        assert np.array_equal(other.pressure, pressure) and pressure.any(), steps
    # What is refused leaves field and view together, and a field that nobody looks at is up to date when somebody does.
    with pytest.raises(ValueError, match="not in the field"):
        field.run(strengths[300:600], (0.0, 0.45))
    del view, seen, pressure
    field.run(strengths[300:], source)
    whole = echolot.Field(own)
    whole.run(strengths, source)
    assert np.array_equal(field.pressure, whole.pressure)


@pytest.mark.parametrize(
    ("strengths", "sources", "receivers", "words"),
    [
        (np.ones(3), (0.0, 0.5), (0.5, 0.5), "not in the field"),
        (np.ones(3), (0.5, np.nan), (0.5, 0.5), "not in the field"),
        (np.ones(3), (0.5, 0.5), (9.0, 0.5), "not in the field"),
        (np.array([1.0, np.inf]), (0.5, 0.5), (0.5, 0.5), "finite"),
        (np.ones((3, 2)), (0.5, 0.5), (0.5, 0.5), "sources"),
        (np.ones(3), np.zeros((4, 1, 2)), (0.5, 0.5), "shape"),
        (np.ones((3, 1, 1)), (0.5, 0.5), (0.5, 0.5), "shape"),
        ("loud", (0.5, 0.5), (0.5, 0.5), "numbers"),
    ],
)
def test_places_and_strengths_that_cannot_be(
    strengths: object, sources: object, receivers: object, words: str
) -> None:
    field = echolot.Field(scene())
    with pytest.raises(ValueError, match=words):
        field.run(strengths, sources, receivers)  # type: ignore[arg-type]
    assert field.steps == 0


def test_a_scene_of_a_file_finds_its_files(tmp_path: Path) -> None:
    poses = "".join(f"{0.05 * k:.3f} {0.5 + 0.01 * k:.4f} 0.5 0 0 0 0 1\n" for k in range(9))
    (tmp_path / "drive.tum").write_text(poses)
    fields = scene().to_dict()
    fields["paths"] = {"measured": {"file": "drive.tum"}}
    own = echolot.Scene.from_dict(fields, folder=tmp_path)
    assert np.isclose(own.paths["measured"], 0.4)
