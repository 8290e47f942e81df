"""Array types used in signatures all over the package."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""States, weights, covariances: always float64."""

IndexArray: TypeAlias = NDArray[np.int64]
"""Indices of particles."""

BoolArray: TypeAlias = NDArray[np.bool_]
"""Masks."""

Image: TypeAlias = NDArray[Any]
"""Pixels, (H, W) grey or (H, W, 3) blue-green-red; dtype said where it matters."""
