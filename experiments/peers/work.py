"""One engine's share of the comparison: leapfrog steps of a square 2-D field in f32 on a given number of threads.

    python work.py {numba,devito,deepwave} CELLS STEPS THREADS

Prints the speed in 10^9 cells per second, the best of three repeats. Setup and compilation are not timed.
`compare.py` runs this in its virtual environment, a process for each engine and number of threads.
"""

import os
import sys
import time

C_MPS = 340.0
DX_M = 0.005
# Courant number 0.4: below what Deepwave takes without splitting steps. The work of a step does not depend on it.
DT_S = 0.4 * DX_M / C_MPS
LAYER_CELLS = 20
REPEATS = 3


def best_rate(cells, steps, work):
    """Runs `work(steps)` once to warm up, then times it."""
    work(min(steps, 8))
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work(steps)
        seconds.append(time.perf_counter() - start)
    return cells * cells * steps / min(seconds) / 1e9


def with_numba(cells, steps, threads):
    """Rigid box, no absorbing layer: an upper bound of what a plain sweep in numba does."""
    import numba
    import numpy as np

    numba.set_num_threads(threads)

    @numba.njit(parallel=True, fastmath=True)
    def sweep(now, past, centre, edge):
        rows, columns = now.shape
        for y in numba.prange(1, rows - 1):
            for x in range(1, columns - 1):
                around = now[y, x - 1] + now[y, x + 1] + now[y - 1, x] + now[y + 1, x]
                past[y, x] = centre * now[y, x] + edge * around - past[y, x]

    courant2 = np.float32((C_MPS * DT_S / DX_M) ** 2)
    centre = np.float32(2.0) - np.float32(4.0) * courant2
    levels = [np.zeros((cells, cells), np.float32) for _ in range(2)]
    levels[0][cells // 2, cells // 2] = 1.0

    def work(count):
        for step in range(count):
            sweep(levels[step % 2], levels[1 - step % 2], centre, courant2)

    return best_rate(cells, steps, work)


def with_devito(cells, steps, threads):
    """Second order in space and time, no absorbing layer, OpenMP."""
    os.environ.update(DEVITO_LANGUAGE="openmp", DEVITO_LOGGING="ERROR", OMP_NUM_THREADS=str(threads))
    from devito import Eq, Grid, Operator, TimeFunction, solve
    import numpy as np

    side_m = DX_M * (cells - 1)
    grid = Grid(shape=(cells, cells), extent=(side_m, side_m), dtype=np.float32)
    pressure = TimeFunction(name="p", grid=grid, time_order=2, space_order=2)
    pressure.data[0, cells // 2, cells // 2] = 1.0
    update = solve(pressure.dt2 - C_MPS**2 * pressure.laplace, pressure.forward)
    operator = Operator(Eq(pressure.forward, update))

    def work(count):
        operator.apply(time_m=1, time_M=count, dt=DT_S)

    return best_rate(cells, steps, work)


def with_deepwave(cells, steps, threads):
    """Second order, CPML of 20 cells inside the given size, one source and one receiver."""
    import deepwave
    import torch

    torch.set_num_threads(threads)
    inner = cells - 2 * LAYER_CELLS
    speed = torch.full((inner, inner), C_MPS)
    place = torch.tensor([[[inner // 2, inner // 2]]])

    def work(count):
        amplitudes = torch.zeros(1, 1, count)
        amplitudes[0, 0, 0] = 1.0
        with torch.no_grad():
            deepwave.scalar(
                speed,
                DX_M,
                DT_S,
                source_amplitudes=amplitudes,
                source_locations=place,
                receiver_locations=place,
                accuracy=2,
                pml_width=LAYER_CELLS,
                pml_freq=5000.0,
            )

    return best_rate(cells, steps, work)


ENGINES = {"numba": with_numba, "devito": with_devito, "deepwave": with_deepwave}

if __name__ == "__main__":
    name, cells, steps, threads = sys.argv[1], *map(int, sys.argv[2:5])
    print(ENGINES[name](cells, steps, threads))
