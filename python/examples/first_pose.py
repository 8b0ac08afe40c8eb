"""A random room, a map of its walls, and a pose from nowhere: ``pose.png``."""

import echolot
import matplotlib.pyplot as plt


def main() -> None:
    scene = echolot.Scene.random("room", seed=7)
    # Image sources take seconds; engine="fdtd" is the sound field, with diffraction, in minutes.
    mapping = echolot.simulate(scene, "mapping", engine="image-source", image_order=4)
    drive = echolot.simulate(scene, "localization", engine="image-source", image_order=4)

    # Poses are known while the walls are learnt, and unknown afterwards.
    room = echolot.EchoMap.build([mapping], method="landmarks")
    found = echolot.localize(drive, room, start="unknown")

    first = found.t[found.sure][0]
    print(f"{found}; sure after {first:.1f} s")
    found.plot(room, drive.truth)
    plt.savefig("pose.png", dpi=120)
    print("wrote pose.png")


if __name__ == "__main__":
    main()
