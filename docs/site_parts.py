"""What the site needs of its own: docstrings as written here, the commands' help, pictures, formulas without a network.

Formulas become MathML, which browsers draw by themselves.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import os
import re
import subprocess
import sys
import typing
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest import mock

import pydantic
from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.inspect import TypeAliasForwardRef

_WIDTH = "78"  # columns of the help
# characters of our formulas that docutils does not know
_TEX = str.maketrans(
    {"°": r"^\circ", "∞": r"\infty ", "∈": r"\in ", "≤": r"\le ", "≥": r"\ge ", "·": r"\cdot ", "×": r"\times "}
)
_REQUESTS = "planner.problem.request"
_PATH = re.compile(r"~?\b(?:[A-Za-z_]\w*\.)+(?=[A-Za-z_])")
_LONGEST = 300  # characters of a constructor's arguments
_CODE = re.compile(r"(``.*?``|:\w+:`.*?`)")


def setup(app: Sphinx) -> dict[str, Any]:
    """Add directives, formulas and events to Sphinx."""
    TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # Sphinx shows its repr for types of properties
    app.add_directive("command-help", CommandHelp)
    app.add_directive("record-keys", RecordKeys)
    app.add_html_math_renderer("mathml", (_inline_math, None), (_display_math, None))
    app.connect("autodoc-process-docstring", _process_docstring)
    app.connect("autodoc-process-signature", _process_signature)
    app.connect("source-read", _add_pictures)
    app.connect("source-read", _add_gallery)
    return {"parallel_read_safe": True}


# docstrings


def _process_docstring(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Indented blocks become code, and bars and stars of formulas lose the meaning they have in reStructuredText."""
    out: list[str] = []
    code = False
    for before, line in zip(["", *lines], lines, strict=False):
        indented = line.startswith("    ")
        if indented and not code and not before.strip():
            out += [".. code-block:: none", ""]
        code = indented or (code and not line.strip())
        out.append(line if code else _escaped(line))
    lines[:] = [*out, *(option_table(obj) if what == "class" else [])]


def _process_signature(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str, str | None] | None:
    """Shorten types to their names, and leave out the constructor of a class with many arguments, as of a result."""
    if not signature:
        return None
    short = re.sub(r"<.*?>", "...", _PATH.sub("", signature))
    if what == "class" and len(short) > _LONGEST:
        short = ""
    return short, _PATH.sub("", returned) if returned else None


def option_table(request: Any) -> list[str]:
    """Return a table of a request's options in reStructuredText, or nothing for other classes."""
    rows = option_rows(request)
    cells = [f"   {'* -' if not k else '  -'} {cell}" for row in rows for k, cell in enumerate(row)]
    return (
        [".. list-table::", "   :header-rows: 1", "", "   * - option", "     - default", "     - meaning", *cells, ""]
        if rows
        else []
    )


def _default_text(value: Any) -> str:
    texts = [getattr(each, "text", each) for each in (value if isinstance(value, tuple) else (value,))]
    return ", ".join(str(text) for text in texts) or "none"


def option_rows(request: Any) -> list[tuple[str, str, str]]:
    """Return name, default and help of each option of a request and of the requests inside it."""
    rows: list[tuple[str, str, str]] = []
    hints = typing.get_type_hints(request, include_extras=True) if request.__module__ == _REQUESTS else {}
    for field in dataclasses.fields(request) if hints else ():
        texts = [
            each.documentation
            for each in getattr(hints[field.name], "__metadata__", ())
            if hasattr(each, "documentation")
        ]
        if texts:
            rows.append((f"``{field.name}``", f"``{_default_text(field.default)}``", _escaped(texts[0])))
        elif dataclasses.is_dataclass(field.default):
            rows += option_rows(type(field.default))
    return rows


def _escaped(line: str) -> str:
    """A line of prose whose ``|``, ``*`` and trailing ``_`` stand for themselves, except in code and roles."""
    parts = _CODE.split(line)
    return "".join(
        part if k % 2 else re.sub(r"(?<!\*)\*(?!\*)|\||_(?=\W|$)", r"\\\g<0>", part) for k, part in enumerate(parts)
    )


# pictures

PICTURES = "<!-- pictures -->"
_PYTHON = re.compile(r"```python\n(.*?)```\n", re.DOTALL)


def _add_pictures(app: Sphinx, name: str, source: list[str]) -> None:
    """On a page with the mark ``PICTURES``: run its Python, and show below each block the figures that it saves."""
    if PICTURES in source[0]:
        folder = Path(app.srcdir) / "_build" / "pictures"
        source[0] = with_pictures(source[0], folder, os.path.relpath(folder, (Path(app.srcdir) / name).parent))


def with_pictures(text: str, folder: Path, link: str) -> str:
    """The page's ``text`` with pictures (PNG, in ``folder``) that stand behind ``link``."""
    from matplotlib.figure import Figure

    folder.mkdir(parents=True, exist_ok=True)
    save, shown, names = Figure.savefig, list[str](), dict[str, Any]()

    def savefig(figure: Figure, file: str, **options: Any) -> None:
        picture = Path(file).with_suffix(".png").name
        save(figure, folder / picture)
        shown.append(picture)

    def ran(block: re.Match[str]) -> str:
        shown.clear()
        exec(block[1], names)
        return block[0] + "".join(f"\n![{picture[:-4]}]({link}/{picture})\n" for picture in shown)

    with mock.patch.object(Figure, "savefig", savefig):
        return _PYTHON.sub(ran, text)


# gallery


def _add_gallery(app: Sphinx, name: str, source: list[str]) -> None:
    """Run the commands of the gallery, whose pages ``html_extra_path`` copies to the site."""
    if name != "gallery":
        return
    folder = Path(app.srcdir) / "_build" / "extra"
    folder.mkdir(parents=True, exist_ok=True)
    for command in re.findall(r"```sh\n(planner .*)\n```", source[0]):
        root = Path(app.srcdir).parent
        words = [str(root / word) if word.startswith("scenes/") else word for word in command.split()]
        subprocess.run(
            [sys.executable, "-m", *words],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(root)},
            check=True,
            capture_output=True,
        )
    for path in folder.rglob("*.*"):
        if path.suffix != ".html":
            path.unlink()


# commands


class CommandHelp(SphinxDirective):
    """``command-help`` PROGRAM: the help of its every command, a section each, as the terminal shows it."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        return [self._section(self.arguments[0], words) for words in commands(self.arguments[0])]

    def _section(self, program: str, words: tuple[str, ...]) -> nodes.section:
        title = " ".join((program, *words))
        section = nodes.section(ids=[nodes.make_id(title)], names=[title])
        section += nodes.title(title, title)
        text = help_text(*words, program=program)
        section += nodes.literal_block(text, text, language="none")
        return section


def commands(program: str = "planner") -> list[tuple[str, ...]]:
    """The words of every command: ``("plan",)``, ``("roadmap", "build")`` and so on, in the order of the help."""
    words: list[tuple[str, ...]] = []
    for first in _subcommands(program=program):
        words += [(first, each) for each in _subcommands(first, program=program)] or [(first,)]
    return words


def help_text(*words: str, program: str = "planner") -> str:
    """What ``PROGRAM WORDS --help`` prints; the program is ``planner`` or ``python -m`` and a package next to it."""
    from benchmarks import commands as benchmarks
    from planner.cli import app
    from reproduce import commands as reproduce

    programs = {"planner": app, "python -m benchmarks": benchmarks, "python -m reproduce": reproduce}
    run = programs[program].run
    out = io.StringIO()
    terminal = {"COLUMNS": _WIDTH, "NO_COLOR": "1", "TERM": "dumb"}
    with mock.patch.dict(os.environ, terminal), contextlib.redirect_stdout(out), contextlib.suppress(SystemExit):
        run([*words, "--help"])
    return out.getvalue().rstrip()


def _subcommands(*words: str, program: str) -> list[str]:
    usage, _, rest = help_text(*words, program=program).partition("\n\n")
    found = None if "positional arguments" in rest else re.search(r"\{([\w,\s-]+)\}(?!\|)", usage)
    return re.split(r",\s*", found.group(1)) if found else []


# files


class RecordKeys(SphinxDirective):
    """``record-keys`` CLASS: a table of the keys of the file that a record is, from its docstrings."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        module, _, name = self.arguments[0].rpartition(".")
        schema = pydantic.TypeAdapter(getattr(import_module(module), name)).json_schema()
        rows = ["| key | what it holds |", "|---|---|", *(f"| `{key}` | {text} |" for key, text in record_keys(schema))]
        return self.parse_text_to_nodes("\n".join(rows) + "\n")


def record_keys(schema: dict[str, Any], part: dict[str, Any] | None = None, before: str = "") -> list[tuple[str, str]]:
    """Every key of a JSON schema with its description, those of inner objects behind a dot, ``[]`` for lists."""
    rows: list[tuple[str, str]] = []
    for key, value in (schema if part is None else part).get("properties", {}).items():
        where, text, kinds = f"{before}{key}", value.get("description", ""), [value, *value.get("anyOf", [])]
        kinds += [kind for each in kinds for kind in each.get("oneOf", [])]
        items = [kind["items"] for kind in kinds if "items" in kind]
        refs = [kind["$ref"].rpartition("/")[2] for kind in (*kinds, *items) if "$ref" in kind]
        inner = [schema["$defs"][ref] for ref in refs]
        if len(inner) == 1:
            text = text or inner[0].get("description", "").partition("\n\n")[0].rstrip(".")
        null = "null" if {"type": "null"} in kinds and "null" not in text else ""
        parts = [text.replace("``", "`").replace("|", "\\|").replace("\n", " "), null and "or `null`"]
        rows.append((where, "; ".join(filter(None, parts))))
        for other in inner:
            kind = other["properties"].get("kind", {}).get("const")
            inside = f"{where}{'[]' if items else ''}."
            if kind:
                rows.append((f'{inside}kind = "{kind}"', other.get("description", "").partition("\n\n")[0]))
            rows += [row for row in record_keys(schema, other, inside) if row[0] != f"{inside}kind"]
    return rows


# formulas


def _inline_math(translator: Any, node: nodes.math) -> None:
    translator.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def _display_math(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f"<div>{_mathml(node, as_block=True)}</div>")
    raise nodes.SkipNode


def _mathml(node: nodes.Element, as_block: bool) -> str:
    return tex2mathml(node.astext().translate(_TEX), as_block=as_block)
