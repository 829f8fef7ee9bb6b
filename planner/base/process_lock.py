"""What belongs to the whole process and is changed for a moment: by one thread at a time.

OMPL's generator of seeds and the file descriptors of standard output and error are there once, whoever plans.
"""

from __future__ import annotations

import threading

PROCESS = threading.RLock()
"""Held around each change of such a thing, until it is as it was; never around work that takes long."""
