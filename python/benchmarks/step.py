"""How much a step of the localizer costs from Python over one from Rust: medians of alternating rounds, one process."""

import statistics
import time

import echolot
import numpy as np


def main() -> None:
    scene = echolot.Scene.random("room", seed=3)
    mapping, drive = (
        echolot.simulate(scene, path, engine="image-source", progress=False) for path in ("mapping", "localization")
    )
    start = drive.start
    assert start is not None
    for method in ("images", "landmarks"):
        known = echolot.EchoMap.build([mapping], method=method)
        odometry = drive.odometry_per_period()
        seconds: dict[str, list[float]] = {"Rust": [], "Python": []}
        for _ in range(7):
            # The same loop, inside of the library and outside.
            stream = echolot.Localizer(known, start=start)
            length = stream.samples_per_period
            sound = np.asarray(drive.signal[: len(odometry) * length])
            began = time.perf_counter()
            stream.run(sound, odometry)
            seconds["Rust"].append(time.perf_counter() - began)
            stream = echolot.Localizer(known, start=start)
            began = time.perf_counter()
            for samples, (v, omega) in zip(sound.reshape(-1, length), odometry, strict=True):
                stream.step(samples, v, omega)
            seconds["Python"].append(time.perf_counter() - began)
        rust, python = (1e3 * statistics.median(seconds[name]) / len(odometry) for name in ("Rust", "Python"))
        print(f"{method}: {rust:.3f} ms a step from Rust, {python:.3f} ms from Python: {python / rust:.3f} times")


if __name__ == "__main__":
    main()
