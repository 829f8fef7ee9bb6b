"""Makes the moving picture of the first page: ``python -m docs.make_picture`` in the repository's folder.

Plans the paper's scenario, opens the page in headless Chromium, and takes a picture at every step of the player.
"""

import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import planner
from planner.tradeoff.sweep import with_alternatives
from tests.browser import Tab, browser

PICTURE = Path(__file__).parent / "_static" / "plan.webp"
FRAMES, SIZE, MILLISECONDS = 30, (800, 608), 90


def frame(tab: Tab, share: float) -> Image.Image:
    """The page with the arm at a share of its path, in the size of the picture."""
    tab.run(f"(s => {{ s.value = {1000 * share}; s.dispatchEvent(new Event('input')); }})(element('scrub'))")
    tab.drawn()
    return Image.fromarray(tab.screenshot().astype(np.uint8)).resize(SIZE, Image.Resampling.LANCZOS)


def main() -> None:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder, browser() as tab:
        with_alternatives(planner.plan()).save(folder)
        assert tab.open(Path(folder) / "plan.html")
        forth = [frame(tab, share) for share in np.linspace(0, 1, FRAMES)]
    frames = [*forth, *[forth[-1]] * 6]
    frames[0].save(
        PICTURE, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0, quality=72, method=6
    )


if __name__ == "__main__":
    main()
