"""The map that fits a net's points to other crops: found in spite of crops that show nothing."""

import pytest

torch = pytest.importorskip("torch")

from makeup_video.training.faces import fit_points
from makeup_video.training.faces.fit_points import affine_of


def shapes(outliers, seed=0):
    """Coefficients (500, 6), the results of a known map, its matrix and shift, and a basis.

    outliers: how many of the results are random instead.
    """
    random = torch.Generator().manual_seed(seed)
    read = torch.randn(500, 6, generator=random, dtype=torch.float64)
    matrix = torch.eye(6, dtype=torch.float64) + 0.1 * torch.randn(
        6, 6, generator=random, dtype=torch.float64
    )
    shift = torch.linspace(-0.3, 0.3, 6, dtype=torch.float64)
    true = read @ matrix + shift
    true[:outliers] = 3 * torch.randn(outliers, 6, generator=random, dtype=torch.float64)
    return read, true, matrix, shift, torch.randn(6, 30, generator=random, dtype=torch.float64)


@pytest.mark.parametrize("outliers", [0, 60])
def test_the_map_is_found_among_crops_that_mislead(outliers, monkeypatch):
    monkeypatch.setattr(fit_points, "RIDGE", 1e-6)
    read, true, matrix, shift, basis = shapes(outliers)
    found, moved = affine_of(read, true, basis)
    torch.testing.assert_close(found, matrix, atol=0.02, rtol=0)
    torch.testing.assert_close(moved, shift, atol=0.02, rtol=0)


def test_few_crops_change_little(monkeypatch):
    read, true, _, _, basis = shapes(0)
    off = []
    for ridge in (0.01, 1.0, 100.0):
        monkeypatch.setattr(fit_points, "RIDGE", ridge)
        found, moved = affine_of(read[:10], true[:10], basis)
        stays = torch.eye(6, dtype=torch.float64)
        off.append(float((found - stays).norm() + moved.norm()))
    assert off == sorted(off, reverse=True) and off[-1] < 0.05
