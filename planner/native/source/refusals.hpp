// Checks of arguments; a failed check raises an error in Python.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "interrupts.hpp"
#include "vector.hpp"

namespace planner {

// rad, m: for larger numbers rounding exceeds the resolution of proofs
constexpr double farthest = 1e6;

struct Refused {
    std::string why;
};

inline void require(bool holds, const char* why) {
    if (!holds) throw Refused{why};
}

// Whether `count` numbers are in [low, high]; NaN is not.
FOR_THIS_PROCESSOR inline bool lie_in(const double* numbers, size_t count, double low, double high) {
    const Four least = Four{} + low, most = Four{} + high;
    FourWhole fit = ~FourWhole{};
    size_t k = 0;
    for (; k + 4 <= count; k += 4) {
        Four four;
        std::memcpy(&four, numbers + k, sizeof four);
        fit &= (four >= least) & (four <= most);
    }
    bool all = fit[0] && fit[1] && fit[2] && fit[3];
    for (; k < count; ++k) all = all && numbers[k] >= low && numbers[k] <= high;
    return all;
}

// Whether numbers are in [-most, most], or in [0, most].
inline bool within(const double* numbers, size_t count, double most) { return lie_in(numbers, count, -most, most); }
inline bool not_negative(const double* numbers, size_t count, double most) { return lie_in(numbers, count, 0.0, most); }

// Whether `count` integers are in [low, high).
inline bool between(const int64_t* numbers, size_t count, int64_t low, int64_t high) {
    bool beyond = false;
    for (size_t k = 0; k < count; ++k) beyond |= numbers[k] < low || numbers[k] >= high;
    return !beyond;
}

// Whether `count` + 1 offsets begin at 0, do not decrease, and end at `last`.
inline bool are_offsets(const int64_t* offsets, size_t count, int64_t last) {
    bool falls = offsets[0] != 0 || offsets[count] != last;
    for (size_t k = 0; k < count; ++k) falls |= offsets[k + 1] < offsets[k];
    return !falls;
}

}  // namespace planner
