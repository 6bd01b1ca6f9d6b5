"""The backlog is what it says after any sequence of comings and goings."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wakeful.scheduling.backlog import Backlog


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 8), st.sampled_from("ab"))))
def test_it_knows_how_many_wait_of_whom_and_since_when(steps: list[tuple[bool, int, str]]) -> None:
    backlog, model = Backlog(), dict[int, tuple[int, str]]()
    for now_ns, (comes, process, source) in enumerate(steps):
        if comes:
            backlog.came(process, source, now_ns)
            model.setdefault(process, (now_ns, source))
        else:
            backlog.left(process)
            model.pop(process, None)
        assert len(backlog) == len(model)
        assert backlog.oldest_ns == min((since for since, _ in model.values()), default=None)
        assert [backlog.of(name) for name in "ab"] == [sum(source == name for _, source in model.values()) for name in "ab"]
