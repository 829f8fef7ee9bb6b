// Sines and cosines of several angles at a time, without branches and calls: fast, and the same bits for all C libraries
// and processors.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "vector.hpp"

namespace planner {

constexpr double farthest_angle = 1e6;  // larger angles use the C library

// sin(angle) to 2e-16 and 1 - cos(angle) to 3e-16, for angles of at most `farthest_angle`.
//
// angle = k pi / 2 + r with |r| <= pi / 4 and a little: k times the first two 33-bit parts of pi / 2 is exact (Cody and
// Waite). The series of sin r and 1 - cos r end below the last bit; k modulo 4 selects sine or cosine and the sign.
INLINED void near_sines(const Four& angle, Four& sine, Four& versine) {
    constexpr double shift = 0x1.8p52;  // its last bit is the unit
    const Four shifted = angle * 0x1.45f306dc9c883p-1 + shift, k = shifted - shift;
    const Four r = ((angle - k * 0x1.921fb544p+0) - k * 0x1.0b4611a6p-34) - k * 0x1.3198a2e037073p-69, z = r * r;
    Four s = Four{} - 1.0 / 1307674368000.0;  // 1 / 15!
    s = s * z + 1.0 / 6227020800.0;
    s = s * z - 1.0 / 39916800.0;
    s = s * z + 1.0 / 362880.0;
    s = s * z - 1.0 / 5040.0;
    s = s * z + 1.0 / 120.0;
    s = s * z - 1.0 / 6.0;
    s = r + r * (z * s);
    Four v = Four{} - 1.0 / 20922789888000.0;  // 1 / 16!
    v = v * z + 1.0 / 87178291200.0;
    v = v * z - 1.0 / 479001600.0;
    v = v * z + 1.0 / 3628800.0;
    v = v * z - 1.0 / 40320.0;
    v = v * z + 1.0 / 720.0;
    v = v * z - 1.0 / 24.0;
    v = 0.5 * z + z * (z * v);
    FourWhole quarter;
    std::memcpy(&quarter, &shifted, sizeof quarter);
    const FourWhole odd = (quarter & 1) != 0, behind = (quarter & 2) != 0;
    const Four across = odd ? 1.0 - v : s, along = odd ? 1.0 + s : v;
    sine = behind ? -across : across;
    versine = behind ? 2.0 - along : along;
}

INLINED void sine_and_versine(const Four& angle, Four& sine, Four& versine) {
    near_sines(angle, sine, versine);
    for (int l = 0; l < 4; ++l)
        if (std::abs(angle[l]) > farthest_angle) sine[l] = std::sin(angle[l]), versine[l] = 1.0 - std::cos(angle[l]);
}

constexpr int most_angles = 8;

// sin and 1 - cos of `count` angles, at most `most_angles`.
FOR_THIS_PROCESSOR inline void sines_and_versines(const double* angles, int count, double* sines, double* versines) {
    for (int first = 0; first < count; first += 4) {
        Four angle = {}, sine, versine;
        for (int l = 0; l < 4 && first + l < count; ++l) angle[l] = angles[first + l];
        sine_and_versine(angle, sine, versine);
        for (int l = 0; l < 4 && first + l < count; ++l) sines[first + l] = sine[l], versines[first + l] = versine[l];
    }
}

// sin and 1 - cos of `count` angles at four configurations each.
INLINED void sines_and_versines(const Four* angles, int count, Four* sines, Four* versines) {
    for (int k = 0; k < count; ++k) sine_and_versine(angles[k], sines[k], versines[k]);
}

}  // namespace planner
