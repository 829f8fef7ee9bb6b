"""Data for any model that is read from files or messages: some of its keys, with right and wrong values."""

from typing import Any, get_args

from hypothesis import strategies as st

from planner.base.yamlfile import models_in

NUMBERS = st.sampled_from([0, 1, 2, 0.5, -0.1, 3.14, 4, 1e9, float("nan"), float("inf"), True, None, 1 << 100])
WORDS = st.sampled_from(["", "a", "panda_hand", "panda_joint1", "world", "box", "sphere", "cylinder", "table", "1.5"])
ROWS = st.sampled_from([[], [0, 0, 0], [0, 0, 0, 1], [0.1, 0.2, 0.3], [0.5, 0.5, 0.5, 0.5], [float("nan")] * 3])


def data_of(model: Any, unknown: bool = False) -> st.SearchStrategy[Any]:
    """Some keys of a model; with ``unknown``, also a key that it does not have."""
    fields = getattr(model, "model_fields", None) or getattr(model, "__dataclass_fields__", {})
    keys = {getattr(field, "alias", None) or name: values_of(field) for name, field in fields.items()}
    return st.fixed_dictionaries({}, optional=keys | ({"unknwon": NUMBERS} if unknown else {}))


def values_of(field: Any) -> st.SearchStrategy[Any]:
    """Values for a field, by its annotation."""
    annotation = getattr(field, "annotation", None) or getattr(field, "type", field)
    models, text = list(models_in(annotation)), str(annotation)
    plain = ROWS | NUMBERS | WORDS if "float" in text or "int" in text else WORDS | st.booleans()
    inner = st.one_of(*(data_of(model) for model in models[:3])) if models else plain
    is_list = any(part is Ellipsis for part in get_args(annotation)) or "list" in text
    return st.lists(inner, max_size=2) | (st.nothing() if models else plain) if is_list else inner
