"""The files that are changed: sound ones load."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.fuzz.cases import kinds
from benchmarks.fuzz.run import judge, make


@pytest.mark.parametrize("kind", kinds())
def test_the_unchanged_file_loads(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise every case is refused for one reason, and nothing is tested."""
    for name in ("mutated_text", "mutated_bytes", "mutated_xml"):
        as_it_is = lambda data, rng: data.encode() if isinstance(data, str) else data  # noqa: E731
        monkeypatch.setattr(f"benchmarks.fuzz.cases.{name}", as_it_is)
    monkeypatch.setattr("benchmarks.fuzz.cases.mutated_tree", lambda data, rng: data)
    monkeypatch.setattr("benchmarks.fuzz.cases._odd_array", lambda array, rng: array)
    file = tmp_path / f"file{kinds()[kind].suffix}"
    file.write_bytes(make(0, 0, kinds()[kind]))
    assert judge(kinds()[kind].use, file) == ("loaded", "")
