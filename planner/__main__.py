"""The program: ``python -m planner`` and the command ``planner``."""

import gc

from planner.base.interrupts import leave_on_interrupt

_ALLOCATIONS_PER_COLLECTION = 50_000  # of objects that stay: importing libraries makes hundreds of thousands


def main() -> None:
    """Run the command line; Ctrl-C is seen to before anything else is loaded."""
    leave_on_interrupt()
    gc.set_threshold(_ALLOCATIONS_PER_COLLECTION)
    from planner.cli import main as command_line

    try:
        command_line()
    finally:
        gc.freeze()  # the process ends: what it holds need not be searched for cycles


if __name__ == "__main__":
    main()
