"""``planner serve``."""

from __future__ import annotations

from pathlib import Path

from planner.base.errors import InstallationError
from planner.cli.common import Debug
from planner.cli.terminal import say


def serve(
    host: str = "127.0.0.1",
    port: int = 0,
    token_file: Path | None = None,
    allow_xacro: bool = False,
    debug: Debug = False,
) -> int:
    """Serve the gate and the planner to programs in other languages, over a websocket, until Ctrl-C.

    Messages are JSON: load a robot and a scene, check chunks of joint targets, change the world, plan with progress
    and cancel. 'planner schema serve' describes them; docs/howto/serve.md has clients. Example:

    planner serve --host 0.0.0.0 --port 8765 --token-file token

    Args:
        host: Address to listen on: this machine's own, so that no other reaches it.
        port: Port to listen on; any free one where left out.
        token_file: File with the token that clients send; a random one is written where there is no such file.
        allow_xacro: Expand robots that are written as xacro, whose expressions run on this machine.
    """
    try:
        from planner.serve.server import serve as run
    except ModuleNotFoundError as error:
        if error.name != "websockets":
            raise
        raise InstallationError(
            "serving needs the Python package websockets: run pip install 'gabf-planner[serve]'."
        ) from None
    run(host, port, token_file, allow_xacro, say)
    return 0
