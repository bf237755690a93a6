"""What `paper --quick` changes in the configs: grids and times so small that everything takes two minutes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

SHORT = "effort.max_duration=6000"

CHANGES: Mapping[str, Sequence[str]] = {
    "bound": ("axes.ensemble.num=2",),
    "figure_05": ("axes.Omega1.num=10", "axes.c.num=5", SHORT),
    "figure_07": ("axes.Omega1.num=29", "measures.samples.max=20", SHORT),
    "figure_09": ("axes.Omega1.num=10", "axes.Ix.num=5", SHORT),
    "figure_10": ("axes.Omega1.num=29", "measures.samples.max=20", SHORT),
    "hover": (SHORT,),
    "hover_ix": ("axes.Ix.num=21", SHORT),
    "lifetime_map": ("axes.Omega1.num=4", "axes.c.num=3", "axes.ensemble.num=32", "integrate.duration=2000"),
    **{f"margin_case_{case}": ("integrate.duration=1000",) for case in (1, 2, 3)},
    "remark_3": ("axes.Omega1.num=4", "axes.c.num=3"),
}
MARGIN_POINTS = 3  # of a margin's scan, each way
