"""Tables of a notebook."""

from __future__ import annotations

from planner.base.html import html_table


def test_names_out_of_files_are_no_markup() -> None:
    table = html_table("<b>", [("<i>", "a & b")], ("<th>",))
    assert "&lt;b&gt;" in table
    assert '<td style="text-align:left">&lt;i&gt;</td>' in table
    assert "a &amp; b" in table
    assert "&lt;th&gt;</th>" in table
