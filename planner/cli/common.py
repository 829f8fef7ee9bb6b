"""What the commands share: when the process began, and the kind of a flag."""

from __future__ import annotations

import time

import tyro

STARTED = time.perf_counter()

Flag = tyro.conf.FlagCreatePairsOff[bool]
