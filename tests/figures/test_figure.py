"""The one place for figures: every name is a function that takes data and hands back a figure."""

import inspect

from planner.figures import figure


def test_every_name_is_a_function_with_a_docstring_of_its_own() -> None:
    assert sorted(figure.__all__) == figure.__all__
    for name in figure.__all__:
        function = getattr(figure, name)
        assert function.__name__ == name
        assert function.__doc__
        assert inspect.signature(function).return_annotation == "Figure"
