// NumPy's arrays as arguments and results, and the scope of a call.
#pragma once

#include <array>
#include <memory>
#include <numeric>
#include <optional>
#include <string>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <unistd.h>

#include "../refusals.hpp"

namespace planner {

namespace nb = nanobind;
using namespace nb::literals;

constexpr int any = -1;  // any length

// An array of one type and shape; other arrays are refused, and copied if not in C order.
template <class T, int... Shape>
struct Given {
    nb::ndarray<const T, nb::shape<Shape...>, nb::c_contig, nb::device::cpu> array;

    const T* data() const { return array.data(); }
    operator const T*() const { return array.data(); }
    int count(int axis = 0) const { return static_cast<int>(array.shape(axis)); }
    size_t size() const { return array.size(); }

    // Return the array; refuse other lengths, except for `any`.
    const Given& of(std::array<int64_t, sizeof...(Shape)> lengths) const {
        for (size_t k = 0; k < lengths.size(); ++k)
            if (lengths[k] != any && lengths[k] != static_cast<int64_t>(array.shape(k)))
                throw Refused{"an array has a length of " + std::to_string(array.shape(k)) + " where " +
                              std::to_string(lengths[k]) + " is needed"};
        return *this;
    }
};
template <int... Shape>
using Floats = Given<double, Shape...>;
template <int... Shape>
using Ints = Given<int64_t, Shape...>;
using Bools = Given<bool, any>;
using Limits = std::pair<Floats<any>, Floats<any>>;  // the lowest and the highest value of each joint
using States = Floats<any, any>;                     // rows of joint values
using Coefficients = Floats<any, any, any>;          // (pieces, degree + 1, dof) of q(s), s in [0, 1]
using Rotations = Floats<any, any, 3, 3>;            // of the base and all joints in some configurations
using Positions = Floats<any, any, 3>;

template <class T>
const uint8_t* bytes_of(const T& flags) {
    return reinterpret_cast<const uint8_t*>(flags.data());
}
template <class T>
auto data_of(const std::optional<T>& array) {
    return array ? array->data() : nullptr;
}

// An array that a call fills and returns to Python.
template <class T, size_t N>
struct Made {
    std::array<size_t, N> shape;
    std::unique_ptr<T[]> filled;

    template <class... Length>
    explicit Made(Length... lengths) : shape{static_cast<size_t>(lengths)...}, filled(new T[size()]) {}
    size_t size() const { return std::accumulate(shape.begin(), shape.end(), size_t{1}, std::multiplies<>()); }
    T* data() const { return filled.get(); }
    operator T*() const { return filled.get(); }
    template <class Index>
    T& operator[](Index k) const {
        return filled[k];
    }
    // The same with fewer rows.
    Made first(size_t rows) {
        shape[0] = rows;
        return std::move(*this);
    }
};

template <class T>
Made<T, 1> made_of(const std::vector<T>& values) {
    Made<T, 1> made(values.size());
    std::copy(values.begin(), values.end(), made.data());
    return made;
}

template <class T, size_t N>
Made<T, N> copy_into(const T* values, Made<T, N> made) {
    std::copy_n(values, made.size(), made.data());
    return made;
}

// A constructor from a function.
template <class T, class... Arguments>
auto construct_by(T (*make)(Arguments...)) {
    return [make](T* self, Arguments... given) { new (self) T(make(given...)); };
}

// Scope without Python's global lock, in which long work polls for Ctrl-C.
class AtWork {
   public:
    AtWork() : thread_(PyEval_SaveThread()) {}
    ~AtWork() {
        try {
            PyEval_RestoreThread(thread_);
        } catch (...) {  // Python finalizes, and unwinds threads that take the lock
            for (;;) pause();
        }
    }
    AtWork(const AtWork&) = delete;

   private:
    const Working working_;
    PyThreadState* const thread_;
};
inline constexpr nb::call_guard<AtWork> at_work;

}  // namespace planner

namespace nanobind::detail {

template <class T, int... Shape>
struct type_caster<planner::Given<T, Shape...>> {
    using Array = decltype(planner::Given<T, Shape...>::array);
    using Own = planner::Given<T, Shape...>;
    NB_TYPE_CASTER(Own, make_caster<Array>::Name)

    bool from_python(handle source, uint32_t flags, cleanup_list* cleanup) noexcept {
        constexpr uint32_t convert = static_cast<uint32_t>(cast_flags::convert);
        make_caster<Array> found;
        bool fits = found.from_python(source, flags & ~convert, cleanup);
        if (!fits) {
            make_caster<ndarray<const T, nanobind::shape<Shape...>, device::cpu>> strided;
            fits = strided.from_python(source, flags & ~convert, cleanup) &&
                   found.from_python(source, flags | convert, cleanup);
        }
        if (fits) value.array = std::move(found.value);
        return fits;
    }
};

template <class T, size_t N>
struct type_caster<planner::Made<T, N>> {
    using Array = ndarray<numpy, T, ndim<N>>;
    using Own = planner::Made<T, N>;
    NB_TYPE_CASTER(Own, make_caster<Array>::Name)

    static handle from_cpp(planner::Made<T, N>&& made, rv_policy, cleanup_list* cleanup) noexcept {
        T* const data = made.filled.release();
        const capsule owner(data, [](void* array) noexcept { delete[] static_cast<T*>(array); });
        return make_caster<Array>::from_cpp(Array(data, N, made.shape.data(), owner), rv_policy::automatic, cleanup);
    }
};

}  // namespace nanobind::detail
