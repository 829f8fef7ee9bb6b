# Built by a binding generator without type information: everything is Any.
from typing import Any

def __getattr__(name: str) -> Any: ...
