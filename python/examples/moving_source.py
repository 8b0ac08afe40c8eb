"""A tone that drives past a microphone: its Doppler shift against the exact one, ``doppler.png``."""

import echolot
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray


def instantaneous_frequency(signal: NDArray[np.float32], rate: float) -> NDArray[np.float64]:
    """From the phase of the analytic signal."""
    spectrum = np.fft.fft(signal)
    spectrum[len(signal) // 2 :] = 0.0
    phase = np.unwrap(np.angle(np.fft.ifft(2 * spectrum)))
    frequency: NDArray[np.float64] = np.gradient(phase) * rate / (2 * np.pi)
    return frequency


def main() -> None:
    scene = echolot.Scene.from_dict(
        {
            "name": "fly-by",
            "medium": {"temperature_degc": 20, "relative_humidity_percent": 50},
            "grid": {"nx": 600, "ny": 200, "dx_m": 0.005, "dt_s": 8e-6},
        }
    )
    field = echolot.Field(scene)
    v, frequency, ear = 30.0, 4000.0, np.array([1.5, 0.65])
    t = field.dt * np.arange(1, int(0.075 / field.dt))
    source = np.stack([0.4 + v * t, np.full_like(t, 0.35)], axis=1)
    # In from silence over 2 ms, so that no click starts the tone.
    strength = 1e-3 * np.sin(2 * np.pi * frequency * t) * np.clip(t / 2e-3, 0, 1)
    heard = field.run(strength, source, ear)

    # What is heard at t left at t' = t - r(t') / c: the fixed point of a contraction.
    c, left = scene.speed_of_sound, t.copy()
    for _ in range(30):
        left = t - np.hypot(0.4 + v * left - ear[0], 0.35 - ear[1]) / c
    exact = frequency * np.gradient(left, t)

    measured = instantaneous_frequency(heard, 1 / field.dt)
    smooth = np.convolve(measured, np.ones(501) / 501, mode="same")
    middle = slice(int(0.012 / field.dt), int(0.066 / field.dt))
    off = np.abs(smooth - exact)[middle].max()
    print(f"from {exact[middle].max():.1f} to {exact[middle].min():.1f} Hz, at most {off:.2f} Hz off")

    ax = plt.subplots(figsize=(6, 3.5), layout="constrained")[1]
    ax.plot(1e3 * t[middle], smooth[middle], lw=3, color="0.7", label="heard in the field")
    ax.plot(1e3 * t[middle], exact[middle], lw=1, color="C0", label="exact")
    ax.set(xlabel="time [ms]", ylabel="frequency [Hz]", title=f"{frequency:.0f} Hz driving past at {v:.0f} m/s")
    ax.legend(frameon=False)
    plt.savefig("doppler.png", dpi=120)
    print("wrote doppler.png")


if __name__ == "__main__":
    main()
