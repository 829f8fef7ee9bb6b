"""The program ``python -m benchmarks``: every benchmark is a command."""

from planner.__main__ import run


def main() -> None:
    """Run the command line of the benchmarks, which ends as the planner's does."""
    from benchmarks import commands
    from planner.cli import run_and_exit

    run_and_exit(commands.run)


if __name__ == "__main__":
    run(main)
