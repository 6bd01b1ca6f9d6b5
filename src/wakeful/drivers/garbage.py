"""Python's garbage collector, set for a process that lives long and keeps much: it looks at what is new, not at all there is.

What a mind keeps (events, processes, experience) is freed by reference counts alone: no cycle in it outlives a step.
The collector's full passes find nothing there and take longer the more is kept: they, and not bytes, limit how many can
wait without a pause.
"""

from __future__ import annotations

import gc

#: A pass over young objects after so many more allocations than deallocations; a full pass hardly ever.
YOUNG, MIDDLE, OLD = 50_000, 20, 1_000


def settle() -> None:
    """Call it once, when what was recovered is in memory: it is not looked at again, and full passes become rare.

    It is a setting of the whole Python process: for programs in which the mind is not the main thing, leave it.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(YOUNG, MIDDLE, OLD)
