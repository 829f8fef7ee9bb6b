"""Text that no name out of a file can steer a terminal with, or break a line of. Imports nothing."""


def printable(text: str, keep: str = "") -> str:
    """``text`` with what is not printable escaped: control characters, what changes the direction of writing.

    ``keep``: characters that stay as they are, as ends of lines.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode() for c in text)
