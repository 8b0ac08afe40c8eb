"""Sound of moving sources and receivers in 2-D, and localization of a robot by its echoes.

>>> import echolot
>>> scene = echolot.Scene.random("room", seed=7)
>>> mapping, drive = (
...     echolot.simulate(scene, path, engine="image-source", progress=False) for path in ("mapping", "localization")
... )
>>> room = echolot.EchoMap.build([mapping], method="landmarks")
>>> found = echolot.localize(drive, room)
>>> found.scores["mae_m"] < 0.01
True

SI units and radians; x right, y up, headings counter-clockwise from +x; arrays of a plane are ``[iy, ix]``; angles of
arrival count from the heading, 0 to pi; time 0 is the first sample of the first period. Bad input raises ``ValueError``
that names field and remedy, a file that cannot be read or written ``OSError``; doubts about an answer are warnings.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import interchange, metrics
from ._echolot import (
    DopplerBank,
    EchoMap,
    Estimate,
    Field,
    Localization,
    Localizer,
    Parameters,
    Recording,
    Scene,
    Study,
    Trajectory,
    __version__,
    localize,
)
from ._echolot import simulate as _simulate
from ._echolot import slam as _slam
from ._echolot import transmit as _transmit
from ._progress import Progress, report

__all__ = [
    "DopplerBank",
    "EchoMap",
    "Estimate",
    "Field",
    "Localization",
    "Localizer",
    "Parameters",
    "Recording",
    "Scene",
    "Study",
    "Trajectory",
    "__version__",
    "interchange",
    "localize",
    "metrics",
    "simulate",
    "slam",
    "transmit",
]


def simulate(
    scene: Scene,
    path: str,
    *,
    engine: str = "fdtd",
    image_order: int | None = None,
    scheme: str | None = None,
    spread: str | None = None,
    walls: str | None = None,
    free_field: bool = False,
    whole_domain: bool = False,
    with_direct: bool = False,
    absorption: bool = False,
    odometry_bias: float = 0.01,
    robot: str | os.PathLike[str] | None = None,
    threads: int = 0,
    progress: bool | Progress = True,
) -> Recording:
    """Simulates a drive of a scene, as ``echolot simulate``.

    ``engine`` is ``"fdtd"`` (the sound field) or ``"image-source"`` (rigid walls without diffraction: seconds instead
    of minutes; ``image_order`` reflections, 2 unless given). ``scheme`` (``"slf"``, ``"m13"``, ``"o13"``, ``"d25"``,
    ``"iwb"``), ``spread`` (``"bilinear"``, ``"gaussian"``, ``"kaiser8"``, ``"kaiser12"``) and ``walls``
    (``"cut_cells"``, ``"staircase"``) are the scene's unless given.

    ``free_field`` leaves out the walls, ``with_direct`` simulates the drive without walls too, ``absorption`` is that
    of air by ISO 9613-1 and needs a scene with temperature and humidity. ``odometry_bias`` is a steady error of the
    wheels' turn rate in rad/s; ``robot`` is a file with instruments of a real robot instead.

    ``progress`` shows a bar, or is called with the steps done and those of all. Ctrl-C ends the call at once. No option
    but the physical ones changes a byte, whatever ``threads`` is (0 takes all).
    """
    with report(progress, path) as told:
        return _simulate(
            scene,
            path,
            engine=engine,
            image_order=image_order,
            scheme=scheme,
            spread=spread,
            walls=walls,
            free_field=free_field,
            whole_domain=whole_domain,
            with_direct=with_direct,
            absorption=absorption,
            odometry_bias=odometry_bias,
            robot=robot,
            threads=threads,
            progress=told,
        )


def slam(
    recording: Recording,
    *,
    start: tuple[float, float, float] | None = None,
    periods: int | None = None,
    parameters: Parameters | None = None,
    progress: bool | Progress = True,
) -> Localization:
    """Estimates a drive and a map of landmarks at once, without map and truth, as ``echolot slam``.

    The map's frame is that of the start: ``start`` (x and y in metres, heading in radians), the truth at time 0, the
    start of ``recording.json``, or the origin. Truth serves nothing else but ``scores``. Poses that are not to be
    trusted have the status ``"lost"``.
    """
    with report(progress, "slam") as told:
        return _slam(recording, start=start, periods=periods, parameters=parameters, progress=told)


def transmit(
    seconds: float = 60.0,
    *,
    rate: int = 48000,
    level: float = -6.0,
    code: int = 1023,
    carrier: float = 10e3,
    chips: float = 10e3,
    file: str | os.PathLike[str] | None = None,
    bits: int = 24,
    force: bool = False,
) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """The sound that a loudspeaker plays, whole periods of the code, and its description, as ``echolot transmit``.

    ``rate`` is that of the sound card in Hz, ``level`` the largest sample in decibels of full scale, ``code`` the chips
    of the M-sequence (2^n - 1), ``carrier`` and ``chips`` their frequencies in Hz. With ``file`` a WAV is written and
    its description beside it.
    """
    return _transmit(seconds, rate, level, code, carrier, chips, file, bits, force)
