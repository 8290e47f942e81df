"""Twin of `particle_filter.normal`."""

from __future__ import annotations

import numpy as np
from numpy import float32 as f32
from numpy import int32 as i32

from cable_tracker.arrays import FloatArray, Image
from cable_tracker.compilation import compiled_fast
from cable_tracker.particle_filter.normal import RADIUS_BITS, RADIUS_STEPS

LOG_2 = f32(0.6931471805599453)
HALF_PI = f32(np.pi / 2)
BITS_OF_ROOT_HALF = i32(0x3F3504F3)
MANTISSA_BITS = i32(23)


@compiled_fast
def fill_normals(uniforms: FloatArray, cosines: Image, sines: Image) -> None:
    """Write the float32 normal numbers that uniform ones, shape (n,), make: twice n or more.

    Logarithm, sine and cosine are series without branches, so that the processor does several
    numbers at a time: within 5e-6.
    """
    for i in range(len(uniforms)):
        scaled = uniforms[i] * RADIUS_STEPS
        steps = np.floor(scaled)

        # log(x) = exponent log(2) + log(mantissa), the mantissa between sqrt(1/2) and sqrt(2).
        bits = f32(f32(steps) + f32(1)).view(np.int32)
        exponent = i32(i32(bits - BITS_OF_ROOT_HALF) >> MANTISSA_BITS)
        mantissa = i32(bits - i32(exponent << MANTISSA_BITS)).view(np.float32)
        s = (mantissa - f32(1)) / (mantissa + f32(1))
        z = s * s
        series = f32(1) + z * (f32(1 / 3) + z * (f32(1 / 5) + z * (f32(1 / 7) + z * f32(1 / 9))))
        logarithm = f32(2) * s * series + f32(exponent - i32(RADIUS_BITS)) * LOG_2
        radius = np.sqrt(f32(-2) * logarithm)

        # The direction is a number of quarter turns and an angle of at most half of one.
        turn = f32(scaled - steps) * f32(4)
        quarter = np.floor(turn + f32(0.5))
        a = (turn - quarter) * HALF_PI
        b = a * a
        sine = a * (
            f32(1)
            + b * (f32(-1 / 6) + b * (f32(1 / 120) + b * (f32(-1 / 5040) + b * f32(1 / 362880))))
        )
        cosine = f32(1) + b * (
            f32(-1 / 2) + b * (f32(1 / 24) + b * (f32(-1 / 720) + b * f32(1 / 40320)))
        )
        one, two, three = quarter == f32(1), quarter == f32(2), quarter == f32(3)
        along = sine if one or three else cosine
        across = cosine if one or three else sine
        cosines[i] = -radius * along if one or two else radius * along
        sines[i] = -radius * across if two or three else radius * across
