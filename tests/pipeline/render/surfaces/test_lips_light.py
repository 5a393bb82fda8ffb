"""The light on the lips, where upper and lower lip meet."""

from dataclasses import replace

import heads
import numpy as np
from makeup import close_up, true_face
from makeup_video.pipeline.render.surfaces.lips_twin import light_on_lips, lips_surface


def test_light_at_the_seam_follows_the_mouth_without_steps():
    face = true_face(close_up()[1])
    surface = lips_surface(face)
    upper = surface.upper
    rows = np.arange(upper.shape[0])[:, None]
    luminance = np.where(rows < upper.sum(0).mean(), 0.1, 0.3) + np.zeros_like(upper)
    step_px = surface.grid.step_px() / 8
    lights = []
    for eighths in range(9):
        moved = replace(face, points_px=face.points_px + np.float32([0, eighths * step_px, 0]))
        lights.append(light_on_lips(lips_surface(moved), luminance.astype(np.float32))[0])
    jumps = np.abs(np.diff(lights, axis=0))
    whole = np.abs(lights[-1] - lights[0]).max()
    assert whole > 0.05, "the line has moved by a pixel of the grid"
    assert jumps.max() < whole / 4


def test_a_steep_contour_has_a_smooth_border():
    points = close_up()[1].copy()
    points[:, 0] *= 0.6  # pursed lips
    face = heads.face(points, logits=np.full((80, 112), 30, np.float32))
    odds = lips_surface(face).odds
    steep = np.hypot(*np.gradient(odds))[np.abs(odds) < 6]
    assert np.quantile(steep, 0.95) < 1.3 * np.median(steep)
