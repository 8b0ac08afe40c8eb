"""Progress in terminals and notebooks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

Progress = Callable[[int, int], object]
"""Is told how much is done, and of how much."""


@contextmanager
def report(progress: bool | Progress, label: str) -> Iterator[Progress | None]:
    """What a computation calls: nothing, the caller's function, or a bar that is closed at the end."""
    if callable(progress):
        yield progress
        return
    if not progress:
        yield None
        return
    # Imported here: it looks for a notebook, which takes a moment.
    from tqdm.auto import tqdm

    with tqdm(desc=label, unit=" steps", unit_scale=True, leave=False, delay=1.0) as bar:

        def tell(done: int, of: int) -> None:
            # A drive with its direct wave counts anew for each of them.
            if of != bar.total or done < bar.n:
                bar.reset(total=of)
            bar.update(done - bar.n)

        yield tell
