"""Makes the moving picture of the first page, and the README's: ``python -m docs.make_picture`` at the top.

Plans the paper's scenario, opens the page in headless Chromium, and takes a picture at every step of the player.
"""

import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import planner
from planner.tradeoff.sweep import add_alternatives
from tests.browser import Tab, browser

PICTURE = Path(__file__).parent / "_static" / "plan.webp"
STILL = Path(__file__).parents[1] / "notebooks" / "pictures" / "plan.png"
FRAMES, WIDTH, MILLISECONDS = 30, 800, 90


def frame(tab: Tab, share: float) -> Image.Image:
    """The page with the arm at a share of its path."""
    tab.run(f"(s => {{ s.value = {1000 * share}; s.dispatchEvent(new Event('input')); }})(element('scrub'))")
    tab.drawn()
    return Image.fromarray(tab.screenshot().astype(np.uint8))


def main() -> None:
    """Write both."""
    with tempfile.TemporaryDirectory() as folder, browser() as tab:
        add_alternatives(planner.plan()).save(folder)
        assert tab.open(Path(folder) / "plan.html")
        whole = [frame(tab, share) for share in np.linspace(0, 1, FRAMES)]
    whole[FRAMES // 3].convert("RGB").quantize(256).save(STILL, optimize=True)
    size = WIDTH, round(WIDTH * whole[0].height / whole[0].width)
    forth = [picture.resize(size, Image.Resampling.LANCZOS) for picture in whole]
    frames = [*forth, *[forth[-1]] * 6]
    frames[0].save(
        PICTURE, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0, quality=72, method=6
    )


if __name__ == "__main__":
    main()
