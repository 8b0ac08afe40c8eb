"""To and from other packages: ``xarray``, plain dictionaries, ``pyroomacoustics``.

Trajectories go to ``evo`` and ROS tools as TUM files: ``Trajectory.save`` and ``Trajectory.load``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._echolot import Recording, Scene

if TYPE_CHECKING:
    import xarray

__all__ = ["recording_to_dict", "recording_to_xarray", "scene_of_shoebox"]

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
