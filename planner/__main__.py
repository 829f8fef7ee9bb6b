"""The program: ``python -m planner`` and the command ``planner``."""

from planner.base.interrupts import leave_on_interrupt


def main() -> None:
    """Run the command line; Ctrl-C is seen to before anything else is loaded."""
    leave_on_interrupt()
    from planner.cli import main as command_line

    command_line()


if __name__ == "__main__":
    main()
