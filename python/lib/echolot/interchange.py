"""To and from other packages: ``xarray``, plain dictionaries, ``pyroomacoustics``, ``k-wave-python``.

Trajectories go to ``evo`` and ROS tools as TUM files: ``Trajectory.save`` and ``Trajectory.load``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._echolot import Field, Recording, Scene

if TYPE_CHECKING:
    import xarray

__all__ = ["recording_to_dict", "recording_to_xarray", "run_kwave", "scene_of_shoebox"]

MARGIN_M = 0.4
"""Air around the walls of a room: absorbing layer and stencils."""


def recording_to_dict(recording: Recording) -> dict[str, Any]:
    """``signal`` ``(n,)`` and its times ``t``, ``odometry`` ``(k, 3)``, ``truth`` (``t``, ``poses``) or ``None``,
    ``direct`` or ``None``, and ``meta``. Arrays of sound are views of the recording."""
    truth = recording.truth
    return {
        "t": np.arange(len(recording.signal)) / recording.sample_rate,
        "signal": recording.signal,
        "direct": recording.direct,
        "odometry": recording.odometry,
        "truth": None if truth is None else {"t": truth.t, "poses": truth.poses},
        "meta": recording.meta,
    }


def recording_to_xarray(recording: Recording) -> xarray.Dataset:
    """The same with named axes: ``time`` of the sound, ``log_time`` of the wheels, ``truth_time``; ``meta`` in the
    attributes."""
    import xarray

    parts = recording_to_dict(recording)
    odometry = parts["odometry"]
    data: dict[str, Any] = {
        "signal": ("time", parts["signal"], {"units": "Pa"}),
        "speed": ("log_time", odometry[:, 1], {"units": "m/s"}),
        "turn_rate": ("log_time", odometry[:, 2], {"units": "rad/s"}),
    }
    axes: dict[str, Any] = {"time": ("time", parts["t"], {"units": "s"}), "log_time": odometry[:, 0]}
    if parts["direct"] is not None:
        data["direct"] = ("time", parts["direct"], {"units": "Pa"})
    if parts["truth"] is not None:
        axes["truth_time"] = parts["truth"]["t"]
        for number, (name, units) in enumerate((("x", "m"), ("y", "m"), ("heading", "rad"))):
            data[name] = ("truth_time", parts["truth"]["poses"][:, number], {"units": units})
    return xarray.Dataset(data, coords=axes, attrs=parts["meta"])


def scene_of_shoebox(room: Any, *, dx: float = 0.005, name: str = "shoebox", **fields: Any) -> Scene:
    """A scene with the walls of a ``pyroomacoustics.ShoeBox``: of one in three dimensions its floor plan.

    Walls are rigid, 0.05 m thick and outside of the room's sides; its corner at the origin lies at ``(0.4, 0.4)``. The
    speed of sound is the room's. ``fields`` are those of a scene file, ``paths`` for example, and replace these.
    """
    width, depth = (float(side) for side in np.asarray(room.shoebox_dim)[:2])
    c, half = float(room.c), 0.025
    low, right, top = MARGIN_M - half, MARGIN_M + width + half, MARGIN_M + depth + half
    corners = [[low, low], [right, low], [right, top], [low, top], [low, low]]
    cells = [8 * round((side + 2 * MARGIN_M) / dx / 8 + 0.5) for side in (width, depth)]
    own: dict[str, Any] = {
        "name": name,
        "medium": {"c_mps": c, "rho_kgpm3": 1.2},
        # Below the stability limit of every scheme.
        "grid": {"nx": cells[0], "ny": cells[1], "dx_m": dx, "dt_s": 0.55 * dx / c},
        "walls": [{"points_m": corners, "thickness_m": 2 * half}],
    }
    return Scene.from_dict(own | fields)


def run_kwave(kgrid: Any, medium: Any, source: Any, sensor: Any, *, scheme: str = "m13") -> dict[str, Any]:
    """Runs what was written for k-Wave's ``kspaceFirstOrder`` on a ``Field``: ``{"p": (sensors, times)}`` in Pa.

    ``kgrid``, ``medium``, ``source`` and ``sensor`` are those of ``k-wave-python``, in two dimensions: a homogeneous
    medium without absorption, ``source.p`` (added, without correction) at the points of ``source.p_mask``, and
    ``sensor.mask`` of points, which come in the order of k-Wave. The absorbing layer lies outside of the grid.

    Raises ``ValueError`` for what a ``Field`` does not have.
    """
    size, spacing = (np.asarray(values, dtype=float).ravel() for values in (kgrid.N, kgrid.spacing))
    dx, dt, times = float(spacing[0]), float(kgrid.dt), int(kgrid.Nt)
    if len(size) != 2 or not np.allclose(spacing, dx):
        raise ValueError("kgrid: is not of square cells in two dimensions; make it so")
    c, rho = (np.unique(np.asarray(value, dtype=float)) for value in (medium.sound_speed, medium.density or 1000.0))
    if len(c) != 1 or len(rho) != 1 or getattr(medium, "alpha_coeff", None) is not None:
        raise ValueError("medium: is not homogeneous, or absorbs; give one sound_speed and density, and no alpha_coeff")
    if getattr(source, "p", None) is None or getattr(source, "p_mode", "additive") not in (
        "additive",
        "additive-no-correction",
    ):
        raise ValueError("source: has no p that is added; give p, p_mask and p_mode 'additive'")
    # As many cells as the layer and the stencils take, around k-Wave's.
    margin = 32
    cells = [8 * -(-int(side + 2 * margin) // 8) for side in size]
    # No code is sent, but a scene has one: any that the grid holds.
    carrier = float(c[0]) / dx / 6.5
    scene = Scene.from_dict(
        {
            "name": "k-Wave",
            "medium": {"c_mps": float(c[0]), "rho_kgpm3": float(rho[0])},
            "grid": {"nx": cells[0], "ny": cells[1], "dx_m": dx, "dt_s": dt},
            "layer_cells": 24,
            "scheme": scheme,
            "spread": "bilinear",
            "sample_rate_hz": 6 * carrier,
            "waveform": {"carrier_hz": carrier, "chip_rate_hz": carrier, "band_hz": [0, 1.9 * carrier]},
        }
    )

    def places(mask: Any) -> Any:
        return (np.argwhere(np.asarray(mask) != 0) + margin + 0.5) * dx

    sources = places(source.p_mask)
    signal: Any = np.zeros((times, len(sources)))
    given = np.atleast_2d(np.asarray(source.p, dtype=float))
    signal[: given.shape[1]] = given.T[:times]
    # k-Wave adds 2 c dt / dx times p to the pressure, a source of strength q adds rho c^2 dt / dx^2 times q.
    # It adds half a step earlier: the mean of two neighbours has the phase in between.
    signal = 0.5 * (signal + np.roll(signal, -1, axis=0))
    strengths = signal * 2 * dx / (float(rho[0]) * float(c[0]))
    return {"p": Field(scene).run(strengths, sources, places(sensor.mask)).T}
