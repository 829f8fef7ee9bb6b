"""The words of the house: banned words, short summaries, verbs as names of functions, short sentences in the docs.

``python -m tests.test_words [PATH PART]...`` lists every fault, also those of rooms that are not finished.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

import nbformat
import pytest

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted((ROOT / "planner").rglob("*.py"))
PAGES = [ROOT / "README.md", *(page for page in sorted((ROOT / "docs").rglob("*.md")) if "_build" not in page.parts)]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))

BANNED = re.compile(
    r"\b(nobody|whoever|told|said of|came of|for want of|all the same|by then|beside|aside|once more|anew)\b", re.I
)
# "piece" stands for a polynomial piece only, "room" for a package of the map in contributing.md only
AMBIGUOUS = re.compile(r"\b(room|rooms|roomy|roomier|(?<!polynomial )pieces?)\b", re.I)
ROOMS_ARE_EXPLAINED = {"contributing.md"}

PARTICIPLE = re.compile(
    r"\w+ed|begun|bent|bought|broken|brought|built|chosen|done|drawn|driven|felt|found|gone|got|given|grown|had|heard|held"
    r"|hidden|kept|known|laid|left|lost|made|meant|met|paid|said|seen|sent|shown|spent|stood|taken|thought|thrown|told"
    r"|torn|understood|worn|written"
)
OTHER_WORDS = re.compile(r"(\w+[cx]e|\w*[fnps])eed|embed|shed|bed")

SUMMARY = 100  # characters
SENTENCE = 30  # words


# Python


def docstrings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and text of each docstring."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield node.body[0].lineno, text


def texts(source: str, tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and text of each string and comment: docstrings, messages, help."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def is_participle(name: str) -> bool:
    """Whether a function's name begins with a past participle."""
    first = name.strip("_").split("_")[0]
    return bool(PARTICIPLE.fullmatch(first)) and not first.startswith("is") and not OTHER_WORDS.fullmatch(first)


def functions(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and name of each function that is not a property."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            decorators = {ast.unparse(decorator).rpartition(".")[2] for decorator in node.decorator_list}
            if not decorators & {"property", "cached_property", "setter"}:
                yield node.lineno, node.name


def faults_of_module(path: Path) -> list[str]:
    """The faults of a module, with their lines."""
    source = path.read_text()
    tree = ast.parse(source)
    faults = [
        (line, f"banned word '{match[0]}'") for line, text in texts(source, tree) for match in BANNED.finditer(text)
    ]
    for line, text in docstrings(tree):
        length = len(text.splitlines()[0])
        if length > SUMMARY:
            faults.append((line, f"summary of {length} characters: at most {SUMMARY}"))
    faults += [(line, f"function '{name}' is a participle") for line, name in functions(tree) if is_participle(name)]
    return [f"{path.relative_to(ROOT)}:{line}: {fault}" for line, fault in sorted(faults)]


# pages


def prose(text: str) -> list[str]:
    """The paragraphs, list items and table cells of a page, without code, formulas and link targets."""
    text = re.sub(r"^```\{glossary\}\n(.*?)^```", r"\1", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^\s*(`{3,}).*?^\s*\1", "\n\n", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"\$\$.*?\$\$", "FORMULA", text, flags=re.DOTALL)
    text = re.sub(r"\$[^$\n]+\$", "FORMULA", text)
    text = re.sub(r"\{\w+\}`([^`<]*)(<[^`>]*>)?`", r"\1", text)
    text = re.sub(r"`[^`]*`", "CODE", text)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    blocks: list[str] = [""]
    for line in text.splitlines():
        if line.startswith("    ") and not blocks[-1]:  # indented code, or the text of a glossary entry
            blocks += [line.strip(), ""]
        elif line.lstrip().startswith("|"):
            blocks += [*(cell.strip() for cell in line.split("|")), ""]
        elif re.match(r"\s*([-*]|\d+\.|#+) ", line):
            blocks.append(re.sub(r"^\s*([-*]|\d+\.|#+) ", "", line))
        elif line.strip():
            blocks[-1] += " " + line.strip()
        else:
            blocks.append("")
    return [block.strip() for block in blocks if block.strip()]


def sentences(block: str) -> list[str]:
    """The sentences of a paragraph."""
    return re.split(r"(?<=[.!?])[\"')*]*\s+(?=[A-Z0-9`\"'(*\[βτΩ])", block)


def text_of(path: Path) -> str:
    """The Markdown of a page or notebook."""
    if path.suffix == ".md":
        return path.read_text()
    return "\n\n".join(cell.source for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "markdown")


def faults_of_page(path: Path) -> list[str]:
    """The faults of a page or notebook, each with its sentence."""
    faults = list[str]()
    for sentence in (sentence for block in prose(text_of(path)) for sentence in sentences(block)):
        faults += [f"banned word '{match[0]}': {sentence}" for match in BANNED.finditer(sentence)]
        if path.name not in ROOMS_ARE_EXPLAINED:
            faults += [f"ambiguous word '{match[0]}': {sentence}" for match in AMBIGUOUS.finditer(sentence)]
        count = len([word for word in sentence.split() if re.search(r"\w", word)])
        if count > SENTENCE:
            faults.append(f"{count} words, at most {SENTENCE}: {sentence}")
    return [f"{path.relative_to(ROOT)}: {fault}" for fault in faults]


# tests


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_module_uses_the_words_of_the_house(path: Path) -> None:
    assert not faults_of_module(path)


@pytest.mark.parametrize("path", [*PAGES, *NOTEBOOKS], ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_page_uses_the_words_of_the_house(path: Path) -> None:
    assert not faults_of_page(path)


def test_faults_are_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[__name__], "ROOT", tmp_path)
    module, page = tmp_path / "module.py", tmp_path / "page.md"
    module.write_text(f'def _joined():\n    """{"Long " * 30}"""\n    raise ValueError("told")  # anew\n')
    assert len(faults_of_module(module)) == 4
    page.write_text(f"# Title\n\nOne more piece. {'Word ' * 31}. Short.\n\n- an item beside it\n\n```sh\nbeside\n```\n")
    assert len(faults_of_page(page)) == 3


if __name__ == "__main__":
    for path in (*MODULES, *PAGES, *NOTEBOOKS):
        if len(sys.argv) == 1 or any(part in str(path.relative_to(ROOT)) for part in sys.argv[1:]):
            find = faults_of_module if path.suffix == ".py" else faults_of_page
            sys.stdout.writelines(f"{fault}\n" for fault in find(path))
