"""Uneven light is taken out of a picture, and nothing else is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cable_tracker.cable.measure.picture.illumination import (
    FITS,
    SMALLEST_DEVIATION,
    TUNING,
    _polynomial,
    _robust_fit,
    evenly_lit,
)
from cable_tracker.tracking.robust import GAUSSIAN_MAD

HEIGHT, WIDTH = 120, 160


def coordinates() -> tuple[np.ndarray, np.ndarray]:
    """Return x and y from -1 to 1 over a picture, each of shape (HEIGHT, WIDTH)."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    return (x + 0.5) / WIDTH * 2.0 - 1.0, (y + 0.5) / HEIGHT * 2.0 - 1.0


def lamp(falloff: float) -> np.ndarray:
    x, y = coordinates()
    return np.exp(-falloff * (x**2 + y**2))


def ground(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(80.0, 120.0, (HEIGHT, WIDTH))


def with_strip(ground_levels: np.ndarray, factor: float) -> np.ndarray:
    levels = ground_levels.copy()
    levels[:, 70:90] *= factor
    return levels


def step_at(picture: np.ndarray, rows: slice) -> float:
    """Return how much brighter the strip is than what lies beside it, in some rows."""
    return float(picture[rows, 72:88].mean() - picture[rows, 50:66].mean())


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_a_share_of_nothing_leaves_the_picture_as_it_is(dtype: type) -> None:
    picture = ground().astype(dtype)
    assert evenly_lit(picture, 0.0) is picture


def test_the_full_correction_makes_the_edges_as_bright_as_the_middle() -> None:
    dim = (200.0 * lamp(0.8)).astype(np.float32)
    lit = evenly_lit(dim, 1.0)
    assert dim[0].mean() < 0.5 * dim[HEIGHT // 2].mean()
    assert lit[0].mean() == pytest.approx(lit[HEIGHT // 2].mean(), rel=0.2)


def test_a_strip_is_as_clear_at_the_dim_edge_as_in_the_middle() -> None:
    dim = (with_strip(ground(), 1.5) * lamp(0.8)).astype(np.float32)
    edge, middle = slice(0, 12), slice(54, 66)
    before = step_at(dim, edge) / step_at(dim, middle)
    after = step_at(evenly_lit(dim, 1.0), edge) / step_at(evenly_lit(dim, 1.0), middle)
    assert before < 0.6
    assert after == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("factor", [0.4, 2.0])
@pytest.mark.parametrize("strip", [slice(70, 90), slice(30, 120), slice(0, 70)])
def test_a_cable_is_not_taken_for_light(factor: float, strip: slice) -> None:
    levels = ground()
    levels[:, strip] *= factor
    picture = levels.astype(np.float32)
    assert evenly_lit(picture, 1.0) == pytest.approx(picture, rel=0.1)


@given(
    falloff=st.floats(0.0, 2.0),
    share=st.floats(0.1, 1.0),
    brightness=st.floats(0.0, 255.0),
    is_float=st.booleans(),
)
def test_light_is_raised_within_bounds_and_stays_finite(
    falloff: float, share: float, brightness: float, is_float: bool
) -> None:
    levels = brightness * lamp(falloff)
    picture = levels.astype(np.float32 if is_float else np.uint8)
    lit = evenly_lit(picture, share)
    assert lit.dtype == np.float32 or lit is picture
    assert lit.shape == picture.shape
    assert np.isfinite(lit).all()
    # 1.1 over 0.1: what is dark is raised so many times at most.
    assert (lit <= 11.0 * picture.astype(np.float32) + 1e-3).all()


@pytest.mark.parametrize("levels", [-5.0, 0.0, 1e12])
def test_pictures_of_one_level_stay_of_one_level(levels: float) -> None:
    lit = evenly_lit(np.full((HEIGHT, WIDTH), levels, np.float32), 1.0)
    assert np.allclose(lit, levels, rtol=1e-5)


def reference_fit(levels: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Fit by least squares again and again, each time with weights of the fit before."""
    fitted = np.full(len(levels), np.sort(levels)[len(levels) // 2])
    for _ in range(FITS):
        sizes = np.abs(levels - fitted)
        deviation = max(GAUSSIAN_MAD * np.sort(sizes)[len(sizes) // 2], SMALLEST_DEVIATION)
        roots = 1.0 / (1.0 + (sizes / (TUNING * deviation)) ** 2)
        found = np.linalg.lstsq((terms * roots).T, levels * roots, rcond=None)[0]
        fitted = found @ terms
    return fitted


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.5])
def test_light_is_fitted_as_a_general_solver_fits_it(noise: float) -> None:
    rng, terms = np.random.default_rng(1), _polynomial()
    levels = rng.normal(size=6) @ terms + noise * rng.standard_normal(terms.shape[1])
    levels[::17] += 2.0
    fitted, unexplained = _robust_fit(levels, terms)
    assert fitted == pytest.approx(reference_fit(levels, terms), abs=1e-6)
    assert unexplained == pytest.approx(np.var(levels - fitted) / np.var(levels), abs=1e-9)
