// What the library cannot hold it refuses: a call then returns -1, or no pointer, and planner_refusal() says why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <type_traits>

#include "interrupts.hpp"
#include "vector.hpp"

namespace planner {

// rad, m: of larger numbers rounding leaves fewer digits than distances are proven to
constexpr double farthest = 1e6;

struct Refused {
    const char* why;
};

inline void require(bool holds, const char* why) {
    if (!holds) throw Refused{why};
}

inline thread_local const char* refusal = "";

// What `work` returns, or -1 (no pointer) where it is refused; 0 for work that returns nothing.
template <class Work>
auto answered(Work work) noexcept {
    using Result = decltype(work());
    using Answer = std::conditional_t<std::is_void_v<Result>, int, Result>;
    try {
        const Working working;
        if constexpr (std::is_void_v<Result>) {
            work();
            return Answer{0};
        } else {
            return work();
        }
    } catch (const Refused& refused) {
        refusal = refused.why;
    } catch (const Interrupted&) {
        refusal = "it was interrupted";
    } catch (const std::bad_alloc&) {
        refusal = "it takes more memory than there is";
    } catch (const std::exception&) {
        refusal = "it takes more than the library can hold";
    }
    if constexpr (std::is_pointer_v<Answer>)
        return Answer{nullptr};
    else
        return Answer(-1);
}

// Whether `count` numbers lie in [low, high]; no NaN does.
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

// Whether they lie in [-most, most], and in [0, most].
inline bool within(const double* numbers, size_t count, double most) { return lie_in(numbers, count, -most, most); }
inline bool not_negative(const double* numbers, size_t count, double most) { return lie_in(numbers, count, 0.0, most); }

// Whether `count` whole numbers lie in [low, high).
inline bool between(const int64_t* numbers, size_t count, int64_t low, int64_t high) {
    bool beyond = false;
    for (size_t k = 0; k < count; ++k) beyond |= numbers[k] < low || numbers[k] >= high;
    return !beyond;
}

// Whether `count` + 1 offsets begin at 0, never fall, and end at `last`.
inline bool are_offsets(const int64_t* offsets, size_t count, int64_t last) {
    bool falls = offsets[0] != 0 || offsets[count] != last;
    for (size_t k = 0; k < count; ++k) falls |= offsets[k + 1] < offsets[k];
    return !falls;
}

}  // namespace planner
