"""The program: Ctrl-C is seen to before anything of weight is loaded, and nothing is searched for cycles at its end."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import gc
import sys
import planner.__main__ as program
early = {name for name in sys.modules if name.startswith("planner.")}
assert early <= {"planner.__main__", "planner.base", "planner.base.interrupts"}, early
order = []
program.leave_on_interrupt = lambda: order.append("interrupts")
import planner.cli
planner.cli.main = lambda: order.append("commands")
program.main()
print(order, len(gc.get_objects()) < gc.get_freeze_count())
"""


def test_interrupts_come_first_and_nothing_is_collected_at_the_end() -> None:
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("['interrupts', 'commands'] True\n", "")
