"""Errors of trajectories, as the papers and ``evo`` define them.

>>> import numpy as np
>>> from echolot import Trajectory, metrics
>>> t = np.linspace(0, 10, 201)
>>> truth = Trajectory(t, np.stack([np.cos(t), np.sin(t), t + np.pi / 2], axis=1))
>>> moved = Trajectory(t, truth.poses + [0.3, 0.4, 0.0])
>>> round(metrics.ape(moved, truth)["mean"], 6), round(metrics.ape(moved, truth, align=True)["rmse"], 6)
(0.5, 0.0)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._echolot import Trajectory, associated, errors

__all__ = ["ape", "associated", "rpe"]


def ape(estimate: Trajectory, truth: Trajectory, *, align: bool = False) -> dict[str, float]:
    """Absolute errors of position in metres: ``evo_ape tum truth est``, with ``align`` after the rigid motion that
    makes their root mean square least (``--align``).

    Poses are held against the true pose nearest in time, within 10 ms, or between two. Returns ``rmse``, ``mean`` (the
    papers' MAE), ``median``, ``std``, ``min``, ``max``, ``sse`` and the number ``n`` of poses.
    """
    return _statistics(errors("aligned" if align else "absolute", estimate, truth))


def rpe(estimate: Trajectory, truth: Trajectory) -> dict[str, float]:
    """Errors of the way from each pose to the next, seen from the pose, in metres: ``evo_rpe tum truth est``. Returns
    what ``ape`` does."""
    return _statistics(errors("relative", estimate, truth))


def _statistics(values: NDArray[np.float64]) -> dict[str, float]:
    squares = float(np.sum(values**2))
    return {
        "rmse": float(np.sqrt(squares / len(values))),
        "mean": float(np.mean(values)),
        "median": float(np.median(values)),
        "std": float(np.std(values)),
        "min": float(np.min(values)),
        "max": float(np.max(values)),
        "sse": squares,
        "n": float(len(values)),
    }
