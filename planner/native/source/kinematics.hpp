// The joint tree of a robot: placements of links, Jacobian and manipulability of the tool.
#pragma once

#include <algorithm>
#include <vector>

#include "interrupts.hpp"
#include "sines.hpp"

namespace planner {

constexpr double half_turn = M_PI - 1e-9;  // rad: two ends determine the direction of smaller turns only

struct Joint {
    int parent;  // 0 for the base, else 1 + number of a joint
    bool prismatic;
    int leader;           // the planned joint, itself or the one that it follows
    double factor, zero;  // value = factor * leader's value + zero; 1 and 0 for a planned joint
    Mat turns[3];         // placement P, P [a], P [a] [a]: Rodrigues' formula
    Vec offset, slide;    // in the parent's frame
    Vec axis;             // in its own frame, and in P's frame
};

template <class T>
INLINED MatOf<T> as(const Mat& a) {
    MatOf<T> b;
    for (int k = 0; k < 9; ++k) b.m[k] = T{} + a.m[k];
    return b;
}

// The value x, sin(x) and 1 - cos(x) of each joint, at one configuration or with T = Four at four: the same bits. Several
// joints are computed at once, as one series has long dependencies.
template <class T>
class JointSines {
   public:
    JointSines(const std::vector<Joint>& joints, const T* q, bool follows)
        : joints_(joints), q_(q), follows_(follows) {}

    INLINED void at(int joint, T& value, T& sine, T& versine) {
        const int k = joint % most_angles;
        if (k == 0) begin(joint, std::min(most_angles, static_cast<int>(joints_.size()) - joint));
        value = values_[k], sine = sines_[k], versine = versines_[k];
    }

   private:
    INLINED void begin(int first, int count) {
        values_ = q_ + first;
        for (int k = 0; k < count && follows_; ++k) {
            const Joint& joint = joints_[first + k];
            followed_[k] = joint.factor * q_[joint.leader] + joint.zero, values_ = followed_;
        }
        sines_and_versines(values_, count, sines_, versines_);
    }

    const std::vector<Joint>& joints_;
    const T *q_, *values_ = nullptr;
    bool follows_;
    T followed_[most_angles], sines_[most_angles], versines_[most_angles];
};

INLINED void take_roots(const Four& squares, Four& roots) {
    for (int l = 0; l < 4; ++l) roots[l] = std::sqrt(squares[l]);
}

struct Chain {
    std::vector<Joint> joints;  // planned joints and their followers
    int planned = 0;

    int dof() const { return planned; }
    int size() const { return static_cast<int>(joints.size()); }
    bool follows() const { return size() > planned; }

    // Spread absolute rates (dof,) of planned joints to all joints (size,).
    void spread(const double* rates, double* all) const {
        for (int j = 0; j < size(); ++j) all[j] = std::fabs(joints[j].factor) * rates[joints[j].leader];
    }

    // Frames (size + 1) of the base and all joints at a configuration (dof,), or with T = Four at four.
    template <class T>
    INLINED void place(const T* q, FrameOf<T>* frames) const {
        // assigned entry by entry: copies of a temporary take a tenth of the time
        for (int k = 0; k < 9; ++k) frames[0].turn.m[k] = T{} + (k % 4 == 0 ? 1.0 : 0.0);
        frames[0].shift.x = frames[0].shift.y = frames[0].shift.z = T{};
        JointSines<T> sines(joints, q, follows());
        for (int j = 0; j < size(); ++j) {
            const Joint& joint = joints[j];
            const FrameOf<T>& parent = frames[joint.parent];
            FrameOf<T>& here = frames[j + 1];
            here.shift = parent * joint.offset;
            T value, sine, versine;
            sines.at(j, value, sine, versine);
            if (joint.prismatic) {
                here.shift = here.shift + value * (parent.turn * joint.slide);
                here.turn = parent.turn * as<T>(joint.turns[0]);
                continue;
            }
            MatOf<T> local;
            for (int k = 0; k < 9; ++k)
                local.m[k] = joint.turns[0].m[k] + sine * joint.turns[1].m[k] + versine * joint.turns[2].m[k];
            here.turn = parent.turn * local;
        }
    }

    // Columns (dof,) of the Jacobian of a point on joint `last`, in world axes: 3 linear rows, then 3 angular ones. A
    // follower adds to its leader's column.
    template <class T>
    INLINED void jacobian(const FrameOf<T>* frames, int last, Vec tool, VecOf<T>* linear, VecOf<T>* angular) const {
        const T none = {};
        for (int j = 0; j < dof(); ++j) linear[j] = {none, none, none}, angular[j] = {none, none, none};
        const VecOf<T> point = frames[last] * tool;
        for (int j = last; j > 0; j = joints[j - 1].parent) {
            const Joint& joint = joints[j - 1];
            const VecOf<T> axis = frames[j].turn * joint.axis, along = (T{} + joint.factor) * axis;
            VecOf<T>&by_slide = linear[joint.leader], &by_turn = angular[joint.leader];
            if (joint.prismatic) {
                by_slide = by_slide + along;
            } else {
                by_slide = by_slide + cross(along, point - frames[j].shift);
                by_turn = by_turn + along;
            }
        }
    }
};

// Remove from N vectors of `size` numbers their components along a unit vector; returns the square of the first one's new
// length. The sums are independent of each other.
template <int N>
INLINED void take_away(const Four* unit, int size, Four* vectors, Four& square) {
    Four along[N] = {};
    for (int k = 0; k < size; ++k)
        for (int n = 0; n < N; ++n) along[n] += unit[k] * vectors[n * size + k];
    square = Four{};
    for (int k = 0; k < size; ++k) {
        for (int n = 0; n < N; ++n) vectors[n * size + k] -= along[n] * unit[k];
        square += vectors[k] * vectors[k];
    }
}

// The volume spanned by `count` vectors, at most 6, of `size` numbers, by modified Gram-Schmidt; overwrites them.
INLINED void spanned_volume(Four* vectors, int count, int size, Four& volume) {
    Four square = {};
    for (int k = 0; k < size; ++k) square += vectors[k] * vectors[k];
    volume = Four{} + 1.0;
    for (int i = 0; i < count; ++i) {
        Four *vector = vectors + i * size, *others = vector + size, norm;
        take_roots(square, norm);
        volume *= norm;
        const Four scale = 1.0 / (norm > 1e-300 ? norm : Four{} + 1e-300);
        for (int k = 0; k < size; ++k) vector[k] *= scale;
        const int left = count - i - 1;
        if (left == 5) take_away<5>(vector, size, others, square);
        if (left == 4) take_away<4>(vector, size, others, square);
        if (left == 3) take_away<3>(vector, size, others, square);
        if (left == 2) take_away<2>(vector, size, others, square);
        if (left == 1) take_away<1>(vector, size, others, square);
    }
}

// Working memory of a thread for four configurations.
class FourScratch {
   public:
    Four *q, *vectors;             // (dof,), for manipulability (6 dof,)
    FrameOf<Four>* frames;         // (size + 1,)
    VecOf<Four>*linear, *angular;  // (dof,)

    FourScratch(const FourScratch&) = delete;
    explicit FourScratch(const Chain& chain) : blocks_(13 * chain.dof() + 12 * (chain.size() + 1)) {
        const int dof = chain.dof();
        q = reinterpret_cast<Four*>(blocks_.data());
        vectors = q + dof;
        frames = reinterpret_cast<FrameOf<Four>*>(vectors + 6 * dof);
        linear = reinterpret_cast<VecOf<Four>*>(frames + chain.size() + 1);
        angular = linear + dof;
    }

   private:
    struct alignas(32) Block {  // with narrow registers, a Four alone has an alignment of 16
        double numbers[4];
    };
    std::vector<Block> blocks_;
};

// Positions of a point on joint `last` at the four configurations of the scratch.
FOR_THIS_PROCESSOR inline void points_of_four(const Chain& chain, int last, Vec point, FourScratch& s, Vec* found) {
    chain.place(s.q, s.frames);
    const VecOf<Four> there = s.frames[last] * point;
    for (int l = 0; l < 4; ++l) found[l] = {there.x[l], there.y[l], there.z[l]};
}

// The rows [first, stop) of a Jacobian: 0 to 2 are linear, 3 to 5 angular.
struct JacobianRows {
    int first, stop;
};

// A point on joint `last`.
struct ToolPoint {
    int last;
    Vec point;
};

// Yoshikawa's manipulability w at the four configurations of the scratch, the least of all tools: the volume spanned by
// the rows `span` of a tool's Jacobian, or by its columns if they are fewer.
FOR_THIS_PROCESSOR inline void manipulability_of_four(const Chain& chain, const std::vector<ToolPoint>& tools,
                                                      JacobianRows span, FourScratch& s, double* w) {
    const int dof = chain.dof(), rows = span.stop - span.first;
    chain.place(s.q, s.frames);
    const bool by_row = rows <= dof;
    for (const ToolPoint& tool : tools) {
        chain.jacobian(s.frames, tool.last, tool.point, s.linear, s.angular);
        for (int j = 0; j < dof; ++j) {
            const VecOf<Four>&l = s.linear[j], &a = s.angular[j];
            const Four* const column[6] = {&l.x, &l.y, &l.z, &a.x, &a.y, &a.z};
            for (int r = 0; r < 6; ++r)
                if (r >= span.first && r < span.stop)
                    s.vectors[by_row ? (r - span.first) * dof + j : j * rows + r - span.first] = *column[r];
        }
        Four volume;
        spanned_volume(s.vectors, by_row ? rows : dof, by_row ? dof : rows, volume);
        for (int l = 0; l < 4; ++l) w[l] = &tool == &tools[0] ? volume[l] : std::min(w[l], volume[l]);
    }
}

// A point on joint `inner`, and a box on joint `outer` with its own frame.
struct PointAndBox {
    int inner, outer;
    Vec point;
    Frame frame;
    Vec low, high;
};

// Tests of points in boxes. Consecutive points in one box are a run, in a ball.
struct PointsInBoxes {
    struct Run {
        size_t first, last;
        Vec middle;
        double size;
    };
    static constexpr size_t longest_run = 64;

    Chain chain;
    std::vector<PointAndBox> boxes;
    std::vector<Run> runs;

    void add(const PointAndBox& one) {
        const size_t k = boxes.size();
        boxes.push_back(one);
        if (!runs.empty() && k - runs.back().first < longest_run && is_same_box(boxes[runs.back().first], one)) {
            Run& run = runs.back();
            run.last = k + 1, run.size = std::max(run.size, length(one.point - run.middle) * (1.0 + 1e-12));
        } else {
            runs.push_back({k, k + 1, one.point, 0.0});
        }
    }

    // Call `found(row, box, point in the box's frame)` for points inside their boxes in configurations q (n, dof).
    template <class Found>
    void find(int n, const double* q, Found found) const {
        std::vector<Frame> frames(chain.size() + 1);
        for (int row = 0; row < n; ++row) {
            poll_signal();
            chain.place(q + static_cast<size_t>(row) * chain.dof(), frames.data());
            for (const Run& run : runs) {
                const PointAndBox& box = boxes[run.first];
                const auto own = [&](const Vec& point) {
                    const Vec world = frames[box.inner] * point;
                    const Frame& there = frames[box.outer];
                    return rotate_back(box.frame.turn, rotate_back(there.turn, world - there.shift) - box.frame.shift);
                };
                if (run.size > 0.0 && !is_inside(box, own(run.middle), run.size + rounded)) continue;
                for (size_t k = run.first; k < run.last; ++k) {
                    const Vec at = own(boxes[k].point);
                    if (is_inside(box, at, 0.0)) found(row, static_cast<int>(k), at);
                }
            }
        }
    }

   private:
    static constexpr double rounded = 1e-6;  // m, more than positions are rounded by

    static bool is_inside(const PointAndBox& box, const Vec& at, double reach) {
        return at.x > box.low.x - reach && at.x < box.high.x + reach && at.y > box.low.y - reach &&
               at.y < box.high.y + reach && at.z > box.low.z - reach && at.z < box.high.z + reach;
    }
    static bool is_same_box(const PointAndBox& a, const PointAndBox& b) {
        return a.inner == b.inner && a.outer == b.outer && a.low == b.low && a.high == b.high &&
               a.frame.shift == b.frame.shift && std::equal(a.frame.turn.m, a.frame.turn.m + 9, b.frame.turn.m);
    }
};

}  // namespace planner
