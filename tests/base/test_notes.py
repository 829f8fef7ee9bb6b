"""Notes are grave unless they say otherwise, and alike where they say the same."""

from planner.base.notes import Note


def test_notes_are_values() -> None:
    assert Note("a") == Note("a", grave=True)
    assert {Note("a"), Note("a"), Note("a", grave=False)} == {Note("a"), Note("a", grave=False)}
