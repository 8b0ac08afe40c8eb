"""Pictures of scenes, maps and drives; matplotlib is asked for only here."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ._echolot import EchoMap, Localization, Scene, Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WALL, TRUTH, ESTIMATE, FAINT = "0.15", "0.55", "C0", "0.8"


def _axes(ax: Axes | None, title: str) -> Axes:
    if ax is None:
        try:
            import matplotlib.pyplot as plt
        except ImportError as error:
            raise ImportError("pictures need matplotlib: pip install 'echolot[plot]'") from error
        ax = plt.subplots(figsize=(5.5, 5.0), layout="constrained")[1]
        ax.set_title(title)
    ax.set_aspect("equal")
    ax.set(xlabel="x [m]", ylabel="y [m]")
    return ax


def scene(own: Scene, ax: Axes | None = None) -> Axes:
    ax = _axes(ax, own.name)
    ny, nx = own.shape
    width, height, layer = nx * own.dx, ny * own.dx, own.layer
    for sides, style in (((0.0, 0.0, width, height), "-"), ((layer, layer, width - layer, height - layer), ":")):
        left, low, right, top = sides
        label = "absorbing layer" if style == ":" else None
        ax.plot([left, right, right, left, left], [low, low, top, top, low], style, color=FAINT, lw=1, label=label)
    for number, wall in enumerate(own.walls):
        ax.plot(*wall.T, color=WALL, lw=3, solid_capstyle="butt", label=None if number else "walls")
    for path in own.paths:
        poses = own.drive(path).poses
        line = ax.plot(*poses[:, :2].T, lw=1.2, label=path)[0]
        ax.plot(*poses[0, :2], "o", ms=4, color=line.get_color())
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return ax


def echo_map(own: EchoMap, ax: Axes | None = None) -> Axes:
    if own.intensity is not None:
        ax = _axes(ax, "Echo images added up")
        heard = own.intensity
        image = ax.imshow(heard, origin="lower", extent=own.extent, cmap="magma", vmax=float(np.quantile(heard, 0.999)))
        ax.figure.colorbar(image, ax=ax, label="echo intensity", shrink=0.8)
        return ax
    ax = _axes(ax, "Landmarks")
    named: set[str] = set()
    for landmark in own.landmarks:
        if landmark["is_image"]:
            continue
        kind = landmark["kind"]
        label = None if kind in named else f"{kind}s"
        named.add(kind)
        if kind == "point":
            ax.plot(*landmark["place"], "x", color="C3", ms=6, label=label)
        elif landmark["ends"] is not None:
            ax.plot(*np.array(landmark["ends"]).T, color=WALL, lw=2.5, label=label)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return ax


def localization(
    own: Localization, shown: EchoMap | None = None, truth: Trajectory | None = None, ax: Axes | None = None
) -> Axes:
    error = "" if own.scores is None else f", mean error {1e3 * own.scores['mae_m']:.1f} mm"
    ax = _axes(ax, f"{len(own)} poses{error}")
    shown = shown if shown is not None else own.map
    if shown is not None:
        echo_map(shown, ax)
    if truth is not None:
        ax.plot(*truth.poses[:, :2].T, color=TRUTH, lw=3, label="truth")
    places, sure = own.poses[:, :2], own.sure
    # From an unknown start the first poses are guesses: no line joins them to the path.
    path = np.where(sure[:, None], places, np.nan)
    ax.plot(*path.T, color=ESTIMATE, lw=1.2, label="estimate, sure")
    if not sure.all():
        ax.plot(*places[~sure].T, ".", color="C1", ms=3, label="not sure")
    ax.plot(*places[-1], "o", color=ESTIMATE, ms=4)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return ax
