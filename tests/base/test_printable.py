"""What is no character to print is escaped."""

from planner.base.printable import printable


def test_nothing_steers_a_terminal() -> None:
    assert printable("Stück 3 m²") == "Stück 3 m²"
    assert printable("a\x1b[2J\x9b2J\nb\u202ec\udcff") == "a\\x1b[2J\\x9b2J\\nb\\u202ec\\udcff"
    assert printable("a\nb\x1b", "\n") == "a\nb\\x1b"
