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
        length = known.parameters.samples_per_period
        sound = np.asarray(drive.signal[: len(odometry) * length])

        def rust(stream: echolot.Localizer) -> None:
            stream.run(sound, odometry)

        def python(stream: echolot.Localizer) -> None:
            for samples, (v, omega) in zip(sound.reshape(-1, length), odometry, strict=True):
                stream.step(samples, v, omega)

        # The same loop, inside of the library and outside, by turns.
        loops = (("Rust", rust), ("Python", python))
        for turn in range(8):
            for name, loop in loops if turn % 2 else loops[::-1]:
                stream = echolot.Localizer(known, start=start)
                began = time.perf_counter()
                loop(stream)
                seconds[name].append(time.perf_counter() - began)
        of_rust, of_python = (1e3 * statistics.median(seconds[name]) / len(odometry) for name in ("Rust", "Python"))
        print(f"{method}: {of_rust:.3f} ms a step from Rust, {of_python:.3f} from Python: {of_python / of_rust:.3f} times")


if __name__ == "__main__":
    main()
