"""Spreads colours of eyeshadow over the skin around an eye: how much of each shows in every cell.

The first colours lie in usual places. Then the shares of the colours in all cells and the colours
themselves are fitted in turn, by least squares. Where the fit is still far from the photo, another
colour is tried. Films mix linearly in roots of light (product_film.py). So a cell in which the
share e of each colour shows, with the film's response r and cover c, has the roots

    seen = bare + sum(e (r root - c bare)).

Hair and shadows lie beside makeup. Their places tell them from it: makeup ends around the eye, and
is no denser further out than further in.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.pipeline.look.kinds.density_map import HW, heights, places_across
from makeup_video.pipeline.reference.neutral_face import LUMINANCE
from makeup_video.pipeline.reference.product_film import ProductFilm, bounded
from makeup_video.pipeline.reference.shadow_cells import LIGHTER, VIVID, Cells

MOST = 4  # colours
# What neighbours cost, times the square of their difference, and what any share costs.
_ROUGH, _SPARSE = 0.02, 0.001
_ROUNDS, _NEW_ROUNDS, _STEPS = 2, 2, 20
_ALIKE = 0.2  # two colours whose roots are at most this far apart become one
_KNOWN = 0.4  # a cell whose wanted root is this near to a colour of the fit asks for no new colour
_KEEPS = 1.0  # weight of a colour's previous root, in cells
_NEW_WORTH = 0.25  # a new colour must lessen the squared error, summed over all cells, by this
_NEAR = 2.5, 1.25  # sigma in rows and columns: a new colour is a mean around the worst cell
# The opacity with which a new colour is calculated, and the least response of its cells.
_NEW_OPACITY, _SHOWS = 0.8, 0.15
_DARK = 0.12  # a colour of less luminance, as a share of skin's, is as dark as hair and brows
# Beyond these places cells count as further out: above the crease, beside the inner and the outer
# corner, and below the eye.
_CREASE, _INNER, _OUTER, _BELOW = 1.1, 0.1, 1.0, -0.3
# How much of a dark colour stays in each column when there is a wing: all up to the corner, then
# less.
_WITHOUT_WING = np.clip((_OUTER + 0.25 - places_across()) / 0.25, 0, 1)
_LASHES = 0.8  # lashes darken the lids up to this height
# Blurs of the shares, sigma in columns and rows: before they are compared, and at the end.
_SOFT, _DONE = (0.4, 0.8), (0.3, 0.6)
_LEAST_THROUGH, _FAINTEST = 0.1, 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Colours, in the order of painting.

    roots: (N, 3).  densities: (N, 27, 24), 0..1.  opacities: (N,) of the products.
    """

    roots: np.ndarray
    densities: np.ndarray
    opacities: np.ndarray


def spread(
    seen: np.ndarray,
    cells: Cells,
    roots: np.ndarray,
    shares: np.ndarray,
    most: np.ndarray,
    lined: bool = True,
    winged: bool = False,
) -> Spread:
    """Fit colours to the roots `seen`, (27, 24, 3).

    roots, shares: (N, 3) and (N, 27, 24), the colours to begin with.  most: (3,) the roots of
    white.
    lined: whether eyeliner is worn, too; if not, what is dark only along the lash lines is lashes.
    winged: whether the eyeliner surely has a wing; then a dark place beyond the outer corner is the
    wing.
    """
    fit = _Fit(seen, cells, most)
    if len(roots):
        roots, shares = _merged(*fit.refined(roots, shares, _ROUNDS))
    while len(roots) < MOST:
        new = fit.new_colour(roots, shares)
        if new is None:
            break
        with_new = np.concatenate([shares, np.zeros((1, *HW), np.float32)])
        tried = _merged(*fit.refined(np.vstack([roots, new]), with_new, _NEW_ROUNDS))
        gain = fit.error(roots, shares) - fit.error(*tried)
        if gain < _NEW_WORTH or len(tried[0]) == len(roots):
            break
        roots, shares = tried
    shares = _no_denser_outwards(shares)
    for at in np.flatnonzero(roots**2 @ LUMINANCE < _DARK):
        shares[at : at + 1] = _no_denser_outwards(shares[at : at + 1])
        if not lined:
            shares = _without_lashes(shares, int(at))
        if winged:
            shares[at] *= _WITHOUT_WING
    return Spread(roots, *_as_layers(_softened(shares, _DONE), cells.film.cover))


class _Fit:
    """The least squares of one face."""

    def __init__(self, seen: np.ndarray, cells: Cells, most: np.ndarray) -> None:
        self._cells, self._seen, self._most = cells, seen, most
        self._off = seen - cells.film.bare

    def refined(
        self, roots: np.ndarray, shares: np.ndarray, rounds: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Fit shares and colours in turn, and the shares once more at the end."""
        for _ in range(rounds):
            shares = self._shares(roots, shares)
            roots = self._roots(roots, shares)
        return roots, self._shares(roots, shares)

    def error(self, roots: np.ndarray, shares: np.ndarray) -> float:
        """The squared error summed over all cells by their weights."""
        rest = self._rest(roots, shares)
        return float((self._cells.weights * (rest * rest).sum(-1)).sum())

    def new_colour(self, roots: np.ndarray, shares: np.ndarray) -> np.ndarray | None:
        """(3,) the root of the colour that is missing around the worst cell; None if none is."""
        film = self._cells.film
        film = ProductFilm(film.bare, film.cover, np.maximum(film.response, _SHOWS))
        pure = film.product_for(self._seen, _NEW_OPACITY)
        rest = self._rest(roots, shares)
        clipped = np.clip(pure, 0, self._most)
        known = [np.linalg.norm(clipped - root, axis=-1) < _KNOWN for root in roots]
        may_be = (film.response > _SHOWS) & ~_is_light(pure, film) & ~np.any(known, axis=0)
        off = self._cells.weights * self._cells.reach * (rest * rest).sum(-1) * may_be
        y, x = np.unravel_index(int(_softened(off[None], _SOFT)[0].argmax()), off.shape)
        rows, columns = np.ogrid[: off.shape[0], : off.shape[1]]
        high, wide = _NEAR
        near = off * np.exp(-(((rows - y) / high) ** 2 + ((columns - x) / wide) ** 2) / 2)
        total = float(near.sum())
        if not total:
            return None
        root: np.ndarray = (clipped * near[..., None]).sum((0, 1)) / total
        return root

    def _rest(self, roots: np.ndarray, shares: np.ndarray) -> np.ndarray:
        rest: np.ndarray = self._off - np.einsum("kyxc,kyx->yxc", self._shown(roots), shares)
        return rest

    def _shown(self, roots: np.ndarray) -> np.ndarray:
        """(N, 27, 24, 3): how a share of 1 of each colour would change the root of a cell."""
        film = self._cells.film
        own = film.response[..., None] * roots[:, None, None].astype(np.float32)
        shown: np.ndarray = own - film.cover[..., None] * film.bare
        return shown

    def _shares(self, roots: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """The best shares of these colours, by projected gradient steps with momentum.

        The method is FISTA (Beck and Teboulle 2009).
        """
        shown, weights = self._shown(roots), self._cells.weights
        squares = np.einsum("kyxc,lyxc->klyx", shown, shown) * weights
        wanted = np.einsum("kyxc,yxc->kyx", shown, self._off) * weights
        # for each cell, from Gershgorin's bound on the curvature
        step = 1 / (np.abs(squares).sum(1).max(0) + 8 * _ROUGH)
        at, last, momentum = shares, shares, 1.0
        for _ in range(_STEPS):
            slope = (squares * at).sum(1) - wanted + _ROUGH * _unlike(at) + _SPARSE
            shares = _within(at - step * slope, self._cells.reach)
            grown = (1 + math.sqrt(1 + 4 * momentum * momentum)) / 2
            at = shares + (momentum - 1) / grown * (shares - last)
            last, momentum = shares, grown
        return shares

    def _roots(self, roots: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """The best colours for these shares; they stay near the previous colours."""
        film, weights = self._cells.film, self._cells.weights.ravel()
        parts = (shares * film.response).reshape(len(shares), -1)
        through = self._off + (film.cover * shares.sum(0))[..., None] * film.bare
        normal = (parts * weights) @ parts.T + _KEEPS * np.eye(len(shares))
        return bounded(
            normal, (parts * weights) @ through.reshape(-1, 3) + _KEEPS * roots, self._most
        )


def _within(shares: np.ndarray, most: np.ndarray) -> np.ndarray:
    """The nearest shares (N, 27, 24) with none below 0 and no sum above `most`, (27, 24).

    This is the projection onto a simplex of Duchi et al. 2008.
    """
    largest = np.sort(shares, axis=0)[::-1].cumsum(0)
    counts = np.arange(1, len(shares) + 1, dtype=np.float32)[:, None, None]
    excess = ((largest - most) / counts).max(0, initial=0)
    within: np.ndarray = np.maximum(shares - excess, 0)
    return within


def _is_light(pure: np.ndarray, film: ProductFilm) -> np.ndarray:
    """(27, 24) bool: where products, (27, 24, 3) roots, would be pale and not vivid.

    Such a cell shows light on the skin, or the background behind the face.
    """
    off = film.response[..., None] / np.maximum(film.cover, _SHOWS)[..., None] * pure - film.bare
    light: np.ndarray = (off @ LUMINANCE > LIGHTER) & (off.min(-1) > -VIVID)
    return light


def _merged(roots: np.ndarray, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Colours and their shares, in which colours that are nearly alike are merged into one."""
    while len(roots) > 1:
        off = np.linalg.norm(roots[:, None] - roots, axis=2) + np.tri(len(roots))
        first, second = np.unravel_index(int(off.argmin()), off.shape)
        if off[first, second] > _ALIKE:
            break
        amounts = shares[[first, second]].sum((1, 2)) + _FAINTEST
        roots, shares = roots.copy(), shares.copy()
        roots[first] = amounts @ roots[[first, second]] / amounts.sum()
        shares[first] += shares[second]
        roots, shares = np.delete(roots, second, 0), np.delete(shares, second, 0)
    return roots, shares


def _unlike(shares: np.ndarray) -> np.ndarray:
    """The sum of the differences between each cell and its four neighbours."""
    down, across = np.diff(shares, axis=1), np.diff(shares, axis=2)
    unlike = np.zeros_like(shares)
    unlike[:, 1:] += down
    unlike[:, :-1] -= down
    unlike[:, :, 1:] += across
    unlike[:, :, :-1] -= across
    return unlike


def _no_denser_outwards(shares: np.ndarray) -> np.ndarray:
    """Shares (N, 27, 24) whose sum does not grow outwards from the eye.

    This holds above the crease, and beside and below the eye, where brows and hair begin.
    """
    total = _softened(shares.sum(0, keepdims=True), _SOFT)[0]
    up, down, across = heights(True), heights(False), places_across()
    least = total.copy()
    above = int(np.abs(up - _CREASE).argmin()) + 1
    least[:above] = np.minimum.accumulate(least[:above][::-1])[::-1]
    below = len(up) + int(np.abs(down - _BELOW).argmin())
    least[below:] = np.minimum.accumulate(least[below:])
    outer, inner = (int(np.abs(across - place).argmin()) for place in (_OUTER, _INNER))
    least[:, outer:] = np.minimum.accumulate(least[:, outer:], axis=1)
    least[:, : inner + 1] = np.minimum.accumulate(least[:, inner::-1], axis=1)[:, ::-1]
    limited: np.ndarray = shares * np.minimum(1, least / np.maximum(total, 1e-6))
    return limited


def _without_lashes(shares: np.ndarray, at: int) -> np.ndarray:
    """Shares (N, 27, 24) without the lashes, which the fit took for the dark colour `at`.

    Along the lash lines that colour becomes no denser than a little away from them. The colours
    that lie a little away fill the place that becomes free.
    """
    up, down = heights(True), heights(False)
    upper = np.arange(int(np.abs(up - _LASHES).argmin()), len(up))
    lower = np.arange(len(up) + int(np.abs(down + _LASHES).argmin()), len(up) - 1, -1)
    bare = shares.copy()
    for rows in (upper, lower):  # each from further away towards the lashes
        near = shares[:, rows[:1]]
        hidden = shares[at, rows] - np.minimum.accumulate(shares[at, rows])
        bare[at, rows] -= hidden
        bare[:, rows] += hidden * near / np.maximum(near.sum(0), 1)
    return bare


def _softened(maps: np.ndarray, sigmas: tuple[float, float]) -> np.ndarray:
    """Maps (N, 27, 24), blurred by these sigmas, in columns and rows."""
    across, down = sigmas
    softened = [cv2.GaussianBlur(one, (0, 0), across, sigmaY=down) for one in maps]
    return np.array(softened, np.float32).reshape(maps.shape)


def _as_layers(shares: np.ndarray, cover: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Densities and opacities with which products, painted over each other, show these shares."""
    densities, opacities = np.zeros_like(shares), np.zeros(len(shares))
    through = np.ones_like(cover)
    for at in reversed(range(len(shares))):
        hides = np.clip(shares[at] / np.maximum(through, _LEAST_THROUGH), 0, 1)
        opacities[at] = max(float(hides.max()), _FAINTEST)
        densities[at] = hides / opacities[at]
        through = through * (1 - hides * cover)
    return densities, opacities
