"""The fit of the distribution of skin colours."""

import cv2
import numpy as np
from makeup_video.kernels.colour import to_xyz
from makeup_video.pipeline import find_faces
from makeup_video.training import skin_light
from people import SAMPLES

RNG = np.random.default_rng(0)


def drawn(lightness):
    """Log linear colours on a line from pale to dark, with a little spread beside it."""
    luminance = ((np.asarray(lightness) + 16) / 116) ** 3
    along = np.log(luminance)[:, None] * [0.7, 1.0, 1.3]
    along += RNG.normal(0, 0.02, along.shape)
    return along + np.log(luminance / (np.exp(along) @ to_xyz(1)[1]))[:, None]


def test_the_spread_ignores_how_often_a_lightness_is_listed():
    even = skin_light.fit_covariance(drawn(RNG.uniform(30, 85, 20000)))
    mostly_pale = skin_light.fit_covariance(drawn(30 + 55 * RNG.uniform(0, 1, 20000) ** 0.6))
    np.testing.assert_allclose(mostly_pale, even, rtol=0.1, atol=0.01)


def test_the_mean_ignores_how_often_a_lightness_is_seen():
    pale, dark = drawn(RNG.uniform(70.5, 74, 5000)), drawn(RNG.uniform(41, 44, 50))
    want = skin_light.fit_mean(np.concatenate([pale[:50], dark]))
    assert np.allclose(skin_light.fit_mean(np.concatenate([pale, dark])), want, atol=0.03)


def test_shades_far_from_all_others_are_left_out():
    shades = drawn(RNG.uniform(30, 85, 5000))
    spoilt = shades.copy()
    spoilt[:100, 2] += 3
    assert np.allclose(
        skin_light.fit_covariance(spoilt), skin_light.fit_covariance(shades), atol=0.03
    )


def test_a_list_of_shades_is_read_as_linear_light(tmp_path):
    path = tmp_path / "shades.csv"
    path.write_text("brand,hex\nours,#ffffff\nours,808080\n")
    assert np.allclose(np.exp(skin_light.shades(path)), [[1] * 3, [0.2159] * 3], atol=1e-4)


def test_skin_is_read_where_the_points_are_sure(tmp_path):
    bgr8 = cv2.imread(str(SAMPLES / "portrait.jpg"))
    (face,) = find_faces(np.ascontiguousarray(bgr8[..., ::-1]))
    for name, seen in (("a.png", bgr8), ("b.png", bgr8 // 2), ("c.png", bgr8)):
        cv2.imwrite(str(tmp_path / name), seen)
    np.savez(
        tmp_path / "labels.npz",
        name=["a.png", "b.png", "c.png"],
        points=np.stack([face.points_px] * 3),
        spread=[0.5, 0.5, 2.0],
    )
    bright, dark = sorted(skin_light.faces(tmp_path), key=lambda skin: -skin.sum())
    assert bright[0] > bright[1] > bright[2]  # skin is red rather than blue
    # half the code is about a fifth of the light
    assert np.allclose(bright - dark, np.log(4.8), atol=0.25)
