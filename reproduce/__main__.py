"""The program ``python -m reproduce``: every simulation of the paper is a command."""

from planner.__main__ import run


def main() -> None:
    """Run the command line of the simulations, which ends as the planner's does."""
    from planner.cli import run_and_exit
    from reproduce import commands

    run_and_exit(commands.run)


if __name__ == "__main__":
    run(main)
