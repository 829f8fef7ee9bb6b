"""Make the pictures of README and docs: ``python -m docs.make_picture`` in the root of the repository.

Open pages in headless Chromium: the paper's scenario, with a picture at each step of the player, and the built gallery.
"""

import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import planner
from planner.tradeoff.sweep import add_alternatives
from tests.browser import Tab, browser

DOCS = Path(__file__).parent
MOVING = DOCS / "_static" / "plan.webp"
GALLERY = DOCS / "_static" / "gallery"
FRAMES, WIDTH, MILLISECONDS = 30, 800, 90
SHARES = {"cart": 0.5, "tidy": 0.45}  # of the motion in a picture of the gallery, where it is not 0.35


def frame(tab: Tab, share: float) -> Image.Image:
    """Return a picture of the page with the arm at a share of its path."""
    tab.run(f"(s => {{ s.value = {1000 * share}; s.dispatchEvent(new Event('input')); }})(element('scrub'))")
    tab.drawn()
    picture = Image.fromarray(tab.screenshot().astype(np.uint8))
    size = WIDTH, round(WIDTH * picture.height / picture.width)
    return picture.convert("RGB").resize(size, Image.Resampling.LANCZOS)


def main() -> None:
    """Write the moving picture and one picture of each page of the gallery, which ``make docs`` builds."""
    GALLERY.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, browser() as tab:
        add_alternatives(planner.plan()).save(folder)
        assert tab.open(Path(folder) / "plan.html")
        frames = [frame(tab, share) for share in np.linspace(0, 1, FRAMES)]
        for page in sorted((DOCS / "_build" / "extra" / "gallery").glob("*/*.html")):
            assert tab.open(page)
            name = page.parent.name
            frame(tab, SHARES.get(name, 0.35)).save(GALLERY / f"{name}.webp", quality=75, method=6)
    frames += [frames[-1]] * 6
    frames[0].save(MOVING, save_all=True, append_images=frames[1:], duration=MILLISECONDS, loop=0, quality=72, method=6)


if __name__ == "__main__":
    main()
