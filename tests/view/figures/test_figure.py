"""The list of figures: every name is a function that takes data and returns a figure."""

import inspect

import planner
from planner.view import figures as figure


def test_every_name_is_a_function_with_a_docstring_of_its_own() -> None:
    assert planner.figures is figure
    assert sorted(figure.__all__) == figure.__all__
    for name in figure.__all__:
        function = getattr(figure, name)
        assert function.__name__ == name
        assert function.__doc__
        assert inspect.signature(function).return_annotation == "Figure"
