"""Random MJCF files: trees of bodies with all that decides where MuJoCo puts bodies, sites and geoms."""

from typing import Any

import numpy as np

_TURNS = {"quat": 4, "euler": 3, "axisangle": 4, "xyaxes": 6, "zaxis": 3}
_SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2}


def random_mjcf(rng: np.random.Generator) -> str:
    """The text of an MJCF file with up to twelve bodies in the world and in each other."""
    return _Writer(rng).text()


class _Writer:
    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._bodies = self._joints = self._sites = 0

    def text(self) -> str:
        order = "".join(self._rng.permutation(list("xyzXYZ"))[:3])
        meshes = "".join(f'<mesh name="mesh{k}" {self._mesh()}/>' for k in range(3))
        inner = f'<default class="inner"><joint {self._joint_default()}/><geom {self._place()}/></default>'
        outer = f'<default class="outer"><joint {self._joint_default()}/><site {self._place()}/>{inner}</default>'
        world = "".join(self._body(3) for _ in range(self._rng.integers(1, 3)))
        return (
            f'<mujoco><compiler angle="{self._rng.choice(["degree", "radian"])}" eulerseq="{order}"/>'
            f'<default><mesh scale="{self._numbers(3)}"/>{outer}<default class="plain"/></default>'
            f"<asset>{meshes}</asset><worldbody>{self._geoms()}{world}</worldbody></mujoco>"
        )

    def _body(self, deep: int) -> str:
        self._bodies += 1
        name = f'name="body{self._bodies}"' if self._rng.random() < 0.9 else ""
        child = f'childclass="{self._rng.choice(["outer", "inner"])}"' if self._rng.random() < 0.4 else ""
        joints = "".join(self._joint() for _ in range(self._rng.choice([0, 1, 1, 2, 3])))
        below = "".join(self._framed(self._body(deep - 1)) for _ in range(self._rng.integers(0, 3) if deep else 0))
        inside = f'<geom size="0.1"/>{self._geoms()}{self._framed(self._site())}'  # the first gives it a mass
        return f"<body {name} {child} {self._place()}>{joints}{inside}{below}</body>"

    def _joint(self) -> str:
        self._joints += 1
        pos = f'pos="{self._numbers(3)}"' if self._rng.random() < 0.5 else ""
        own = self._joint_default() if self._rng.random() < 0.5 else ""
        return f'<joint name="joint{self._joints}" type="{self._rng.choice(["hinge", "slide"])}" {pos} {own}/>'

    def _joint_default(self) -> str:
        ref = f'ref="{self._numbers(1)}"' if self._rng.random() < 0.5 else ""
        return f'axis="{self._numbers(3)}" range="{-self._rng.random() - 0.1!r} 1" {ref}'

    def _geoms(self) -> str:
        return "".join(self._framed(self._geom()) for _ in range(self._rng.integers(0, 4)))

    def _geom(self) -> str:
        seen = self._rng.choice(["", 'group="3"', 'contype="0" conaffinity="0"', 'class="inner"'])
        kind = self._rng.choice([*_SIZES, "mesh", "fromto"])
        if kind == "mesh":
            return f'<geom type="mesh" mesh="mesh{self._rng.integers(3)}" {seen} {self._place()}/>'
        if kind == "fromto":
            return f'<geom type="capsule" size="0.1" fromto="{self._numbers(6)}" class="plain"/>'
        size = " ".join(map(repr, self._rng.uniform(0.01, 0.2, _SIZES[kind]).tolist()))
        return f'<geom type="{kind}" size="{size}" {seen} {self._place()}/>'

    def _site(self) -> str:
        self._sites += 1
        return f'<site name="site{self._sites}" {self._place()}/>'

    def _framed(self, text: str) -> str:
        return f"<frame {self._place()}>{text}</frame>" if self._rng.random() < 0.3 else text

    def _mesh(self) -> str:
        shifted = f'refpos="{self._numbers(3)}" refquat="{self._numbers(4)}"' if self._rng.random() < 0.5 else ""
        own = f'scale="{self._numbers(3)}"' if self._rng.random() < 0.5 else ""
        return f'vertex="{self._numbers(24)}" {shifted} {own}'

    def _place(self) -> str:
        pos = f'pos="{self._numbers(3)}"' if self._rng.random() < 0.8 else ""
        turn = str(self._rng.choice(["", *_TURNS]))
        return f'{pos} {turn}="{self._numbers(_TURNS[turn])}"' if turn else pos

    def _numbers(self, count: int) -> Any:
        return " ".join(map(repr, self._rng.normal(size=count).tolist()))
