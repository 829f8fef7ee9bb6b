"""Make the moving picture of README and docs: ``python -m docs.make_picture`` in the root of the repository.

Plan the paper's scenario, open its page in headless Chromium, and take a picture at each step of the player.
"""

import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import planner
from planner.tradeoff.sweep import add_alternatives
from tests.browser import Tab, browser

PICTURE = Path(__file__).parent / "_static" / "plan.webp"
FRAMES, WIDTH, MILLISECONDS = 30, 800, 90


def frame(tab: Tab, share: float) -> Image.Image:
    """Return a picture of the page with the arm at a share of its path."""
    tab.run(f"(s => {{ s.value = {1000 * share}; s.dispatchEvent(new Event('input')); }})(element('scrub'))")
    tab.drawn()
    return Image.fromarray(tab.screenshot().astype(np.uint8))


def main() -> None:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder, browser() as tab:
        add_alternatives(planner.plan()).save(folder)
        assert tab.open(Path(folder) / "plan.html")
        pages = [frame(tab, share) for share in np.linspace(0, 1, FRAMES)]
    size = WIDTH, round(WIDTH * pages[0].height / pages[0].width)
    pictures = [picture.resize(size, Image.Resampling.LANCZOS) for picture in pages]
    frames = [*pictures, *[pictures[-1]] * 6]
    frames[0].save(
        PICTURE, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0, quality=72, method=6
    )


if __name__ == "__main__":
    main()
