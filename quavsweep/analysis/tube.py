"""The tube of a cycle: a neighbourhood that the method's return map takes into itself, and whether an orbit is in it.

Around a point x* of a cycle of period T, z are the D - 1 coordinates of u - x* across the flow (all D in a forced
system), in units of the orbit's amplitude, and A the derivative of the return map there. With all multipliers but the
neutral one inside the unit circle, the metric |z|^2 = z^T P z, P = sum_k (A^T / s)^k (A / s)^k, makes A a contraction
by less than s, which lies half way from its spectral radius to 1.

*Computed, not bounded:* the method of the sweep is run over a period from x* and from the points at +- WIDTH radii
along the axes of the ellipsoid |z| <= radius. From this,

- e, by how much the method's return map moves x*, and q, the norm of its derivative there;
- the radius: the distance of the orbit's last hit from x* and a quarter more, and not less than 4 e / (1 - q);
- at the displaced points, the norm of the derivative stays below (1 + q) / 2, and so do the images' distances.

Where the largest multiplier is negative, all this is done with two periods: close to a doubling the derivative of one
is larger than 1 on one side of x*, but the next return makes up for it.

*What follows:* if the derivative's norm is below (1 + q) / 2 on the whole ellipsoid, the return map takes the ellipsoid
into itself, for e + radius (1 + q) / 2 < radius, and contracts there: the orbit ends on the method's cycle inside.

*What is only checked:* that norm between the points at which it was computed, which lie WIDTH times farther out than
the orbit; the derivative changes little so near (its change is of the order of the displacement, and the ellipsoid may
not exceed a share of the amplitude). Rounding is not followed. The step is that of the sweep up to a tenth longer, so
that it divides the period. Where the equations have kinks, the derivative is that of the flow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quavsweep.analysis.equilibrium import norm
from quavsweep.analysis.flow import Flow
from quavsweep.analysis.kink import tangent_across
from quavsweep.analysis.returns import shortest
from quavsweep.analysis.shooting import METHOD, Closed
from quavsweep.kernels.method import ButcherTable

ROOM = 1.25  # radius of the tube against the distance of the orbit
FLOOR = 4.0  # least radius against e / (1 - q)
WIDTH = 4.0  # radii at which the derivative is computed
DOUBLINGS = 24  # of the sum of the metric: 2^24 terms
UNIT = 1.0 - 1e-6  # largest size of a multiplier whose cycle is certified
SLIM = 0.1  # largest extent of the ellipsoid of WIDTH radii, in units of the orbit's amplitude
NOISE = 1e-9  # of hits, in units of the amplitude
GRADES = tuple(int(8 * 2 ** (k / 8)) for k in range(192))  # numbers of steps, rounded down


@dataclass(frozen=True)
class Tube:
    """What was found of n tubes.

    Parameters
    ----------
    inside : (n,) bool
        The orbit's last hits lie in a neighbourhood that the method takes into itself.
    level, radius : (n,) float64
        Distance of the last hit from the cycle, and radius of the neighbourhood, in the metric of the tube.
    contraction : (n,) float64
        The largest norm of the return map's derivative that was seen.
    """

    inside: np.ndarray
    level: np.ndarray
    radius: np.ndarray
    contraction: np.ndarray


@dataclass(frozen=True)
class Frame:
    """Coordinates across n cycles: z = across^T (u - x*) / amplitude, y = to_y z."""

    point: np.ndarray
    amplitude: np.ndarray
    circle: np.ndarray
    heading: np.ndarray | None
    across: np.ndarray
    to_y: np.ndarray
    to_z: np.ndarray

    def distance(self, u: np.ndarray, velocity: np.ndarray | None = None) -> np.ndarray:
        """Return |y| of states (n, D); with the velocity there, of where their orbits pass the plane across."""
        moved = shortest(u - self.point, self.circle) / self.amplitude
        if velocity is not None and self.heading is not None:
            speed = velocity / self.amplitude
            late = (self.heading * moved).sum(axis=1) / (self.heading * speed).sum(axis=1)
            moved = moved - late[:, None] * speed
        return norm(np.matmul(self.to_y, np.matmul(self.across.transpose(0, 2, 1), moved[:, :, None]))[:, :, 0])

    def stretching(self, derivative: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Return the norm, in the metric, of a derivative of the flow seen across, given the velocity at its end."""
        scaled = derivative * (self.amplitude[:, None, :] / self.amplitude[:, :, None])
        if self.heading is not None:
            speed = velocity / self.amplitude
            along = np.matmul(self.heading[:, None, :], scaled) / (self.heading * speed).sum(axis=1)[:, None, None]
            scaled = scaled - speed[:, :, None] * along
        inner = np.matmul(np.matmul(self.across.transpose(0, 2, 1), scaled), self.across)
        image = np.matmul(np.matmul(self.to_y, inner), self.to_z)
        finite = np.isfinite(image).all(axis=(1, 2))
        image[~finite] = 0.0
        return np.where(finite, np.linalg.svd(image, compute_uv=False)[:, 0], np.inf)

    def rim(self, radius: np.ndarray) -> list[np.ndarray]:
        """Return the points at this distance along the axes of the ellipsoid, (n, D) each."""
        axes = np.matmul(self.across, self.to_z) * (self.amplitude * radius[:, None])[:, :, None]
        return [self.point + sign * axes[:, :, k] for k in range(axes.shape[2]) for sign in (1.0, -1.0)]

    def extent(self) -> np.ndarray:
        """Return how far the ellipsoid of radius one reaches, in units of the amplitude, (n,)."""
        return np.asarray(np.abs(np.matmul(self.across, self.to_z)).max(axis=(1, 2)))

    def noise(self) -> np.ndarray:
        """Return how large an error of hits is in the metric, (n,)."""
        return np.asarray(NOISE * np.abs(self.to_y).sum(axis=(1, 2)))

    def take(self, cells: np.ndarray) -> Frame:
        """Return the coordinates of some of the cycles."""
        heading = None if self.heading is None else self.heading[cells]
        parts = (self.across[cells], self.to_y[cells], self.to_z[cells])
        return Frame(self.point[cells], self.amplitude[cells], self.circle, heading, *parts)


@dataclass(frozen=True)
class ReturnMap:
    """The method's return maps around n cycles.

    Parameters
    ----------
    flow : Flow
    method : ButcherTable
        Of the sweep.
    closed : Closed
    parameters : sequence of (n,) arrays
    frame : Frame
    turns, steps : (n,) int
        Periods in a return, and steps.
    """

    flow: Flow
    method: ButcherTable
    closed: Closed
    parameters: Sequence[np.ndarray]
    frame: Frame
    turns: np.ndarray
    steps: np.ndarray

    def take(self, cells: np.ndarray) -> ReturnMap:
        """Return the maps around some of the cycles."""
        own = [p[cells] for p in self.parameters]
        part, frame = self.closed.take(cells), self.frame.take(cells)
        return ReturnMap(self.flow, self.method, part, own, frame, self.turns[cells], self.steps[cells])

    def images(self, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return how far from the cycles points (n, D) return, and the norms of the derivatives there, (n,) each."""
        flow, closed, own, frame = self.flow, self.closed, self.parameters, self.frame
        time = self.turns * closed.period
        end, derivative, _ = flow.tangent(self.method, start, own, time, self.steps)
        if flow.program.switches and frame.heading is not None:
            derivative = tangent_across(flow, METHOD, start, own, time, self.turns * closed.steps)[1]
        velocity = flow.velocity(end, own) if frame.heading is not None else np.zeros_like(end)
        return frame.distance(end, velocity), frame.stretching(derivative, velocity)

    def contracts(
        self, which: np.ndarray, radius: np.ndarray, missed: np.ndarray, norm_: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return around which of these cycles, (n,) bool, the maps contract, and the largest norm that was seen.

        Parameters
        ----------
        radius, missed : (n,) float64
            Of the neighbourhoods, and how far from themselves the points of the cycles return.
        norm_ : (n,) float64
            Of the derivatives there.
        """
        inside = which & (norm_ < 1.0) & (WIDTH * radius * self.frame.extent() <= SLIM)
        largest, near = norm_.copy(), np.flatnonzero(inside)
        if near.size:
            narrow, reach, limit = self.take(near), WIDTH * radius[near], 0.5 * (1.0 + norm_[near])
            for point in narrow.frame.rim(reach):
                distance, stretched = narrow.images(point)
                inside[near] &= (stretched < limit) & (distance < limit * reach + missed[near])
                largest[near] = np.maximum(largest[near], stretched)
        return inside, largest


def examine_tube(
    flow: Flow,
    method: ButcherTable,
    dt: float,
    closed: Closed,
    slowest: np.ndarray,
    amplitude: np.ndarray,
    circle: np.ndarray,
    parameters: Sequence[np.ndarray],
    hits: Sequence[np.ndarray],
    multiple: np.ndarray | None,
) -> Tube:
    """Say which orbits are inside the tubes of their cycles.

    Parameters
    ----------
    method, dt
        Those of the sweep.
    closed : Closed
        n cycles.
    slowest : (n,) complex128
        The multiplier of largest size but the neutral one.
    amplitude : (n, D) float64
    hits : three of (n, D) float64
        The orbit's last hit near the cycle's point, and those one period and two before; NaN where there is none.
    multiple : (n,) int or None
        Periods of the forcing in one of the cycle; None for an autonomous system, whose velocity is neutral.
    """
    n = len(slowest)
    tube = Tube(np.zeros(n, dtype=bool), *(np.full(n, np.nan) for _ in range(3)))
    good = np.flatnonzero(closed.found & (np.abs(slowest) < UNIT))
    if not good.size:
        return tube
    part, own, amplitude, slowest = closed.take(good), [p[good] for p in parameters], amplitude[good], slowest[good]
    frame = frame_around(part, np.abs(slowest), amplitude, circle, multiple is not None)
    last, once, twice = (frame.distance(hit[good]) for hit in hits)
    turns = np.where(slowest.real < 0, 2, 1)
    before = np.where((turns == 2) & np.isfinite(twice), twice, once)
    steps = _grade(turns * part.period / dt, None if multiple is None else turns * multiple[good])
    with np.errstate(all="ignore"):
        returns = ReturnMap(flow, method, part, own, frame, turns, steps)
        missed, norm_ = returns.images(part.point)
        floor = FLOOR * missed / (1.0 - norm_)
        size = np.maximum(ROOM * last, floor)
        settles = last <= np.maximum(0.5 * (1.0 + norm_) * before + missed + frame.noise(), floor)
        inside, largest = returns.contracts(settles, size, missed, norm_)
    tube.inside[good], tube.level[good], tube.radius[good], tube.contraction[good] = inside, last, size, largest
    return tube


def frame_around(closed: Closed, radius: np.ndarray, amplitude: np.ndarray, circle: np.ndarray, forced: bool) -> Frame:
    """Return the coordinates across cycles, and in them the metric in which the return map contracts."""
    n, dimension = closed.point.shape
    if forced:
        heading, across = None, np.broadcast_to(np.eye(dimension), (n, dimension, dimension)).copy()
    else:
        speed = closed.velocity / amplitude
        heading = speed / norm(speed)[:, None]
        # The columns beside the first of the reflection that takes the first axis to the heading, up to a sign.
        mirror = heading.copy()
        mirror[:, 0] += np.where(heading[:, 0] < 0, -1.0, 1.0)
        square = (norm(mirror) ** 2)[:, None, None]
        across = (np.eye(dimension) - 2.0 * mirror[:, :, None] * mirror[:, None, :] / square)[:, :, 1:]
    scaled = closed.derivative * (amplitude[:, None, :] / amplitude[:, :, None])
    image = np.matmul(np.matmul(across.transpose(0, 2, 1), scaled), across)
    power = image / (0.5 * (1.0 + radius))[:, None, None]
    metric = np.broadcast_to(np.eye(across.shape[2]), image.shape).copy()
    for _ in range(DOUBLINGS):
        metric = metric + np.matmul(np.matmul(power.transpose(0, 2, 1), metric), power)
        power = np.matmul(power, power)
    metric[~np.isfinite(metric).all(axis=(1, 2))] = np.eye(across.shape[2])
    to_y = np.linalg.cholesky(0.5 * (metric + metric.transpose(0, 2, 1))).transpose(0, 2, 1)
    return Frame(closed.point, amplitude, circle, heading, across, to_y, np.linalg.inv(to_y))


def _grade(steps: np.ndarray, multiple: np.ndarray | None) -> np.ndarray:
    """Return numbers of steps, rounded down so that cells share calls; in forced systems those of the sweep."""
    if multiple is not None:
        return np.asarray(multiple * np.maximum(np.rint(steps / multiple).astype(int), 1))
    return np.asarray(GRADES)[np.maximum(np.searchsorted(GRADES, steps, side="right") - 1, 0)]
