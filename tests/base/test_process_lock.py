"""The lock around what belongs to the process: one for all, and a thread that holds it may take it again."""

from __future__ import annotations

import threading

from planner.base.process_lock import PROCESS


def test_one_thread_holds_it_and_may_take_it_again() -> None:
    taken: list[bool] = []
    with PROCESS, PROCESS:
        other = threading.Thread(target=lambda: taken.append(PROCESS.acquire(blocking=False)))
        other.start()
        other.join()
    assert taken == [False]
    assert PROCESS.acquire(blocking=False)
    PROCESS.release()
