// The joint tree of a robot: where its links are, the tool's Jacobian and manipulability.
#pragma once

#include <vector>

#include "vector.hpp"

namespace planner {

struct Joint {
    int parent;           // 0 the base, else the number of a joint + 1
    bool prismatic;
    Mat turns[3];         // placement P, P [a], P [a] [a]: Rodrigues' formula
    Vec offset, slide;    // in the parent's frame
    Vec axis;             // in its own frame, which is also the one it turns about in P's frame
};

template <class T>
INLINED MatOf<T> as(const Mat& a) {
    MatOf<T> b;
    for (int k = 0; k < 9; ++k) b.m[k] = T{} + a.m[k];
    return b;
}

// sin(angle) and 1 - cos(angle); of each of four the same bits as of one.
INLINED void sine_and_versine(const double& angle, double& sine, double& versine) {
    sine = std::sin(angle), versine = 1.0 - std::cos(angle);
}
INLINED void sine_and_versine(const Four& angles, Four& sines, Four& versines) {
    for (int l = 0; l < 4; ++l) sines[l] = std::sin(angles[l]), versines[l] = 1.0 - std::cos(angles[l]);
}

INLINED void take_roots(const Four& squares, Four& roots) {
    for (int l = 0; l < 4; ++l) roots[l] = std::sqrt(squares[l]);
}

struct Chain {
    std::vector<Joint> joints;

    int dof() const { return static_cast<int>(joints.size()); }

    // Frames (dof + 1) of the base and all joints at a configuration, or with T = Four at four.
    template <class T>
    INLINED void place(const T* q, FrameOf<T>* frames) const {
        frames[0] = FrameOf<T>();
        for (int j = 0; j < dof(); ++j) {
            const Joint& joint = joints[j];
            const FrameOf<T>& parent = frames[joint.parent];
            FrameOf<T>& here = frames[j + 1];
            here.shift = parent * joint.offset;
            if (joint.prismatic) {
                here.shift = here.shift + q[j] * (parent.turn * joint.slide);
                here.turn = parent.turn * as<T>(joint.turns[0]);
                continue;
            }
            T sine, versine;
            sine_and_versine(q[j], sine, versine);
            MatOf<T> local;
            for (int k = 0; k < 9; ++k)
                local.m[k] = joint.turns[0].m[k] + sine * joint.turns[1].m[k] + versine * joint.turns[2].m[k];
            here.turn = parent.turn * local;
        }
    }

    // Columns of the Jacobian of a point that joint `last` carries, in world axes: 3 linear rows, then 3 angular ones.
    template <class T>
    INLINED void jacobian(const FrameOf<T>* frames, int last, Vec tool, VecOf<T>* linear, VecOf<T>* angular) const {
        for (int j = 0; j < dof(); ++j) linear[j] = angular[j] = VecOf<T>();
        const VecOf<T> point = frames[last] * tool;
        for (int j = last; j > 0; j = joints[j - 1].parent) {
            const Joint& joint = joints[j - 1];
            const VecOf<T> axis = frames[j].turn * joint.axis;
            if (joint.prismatic) {
                linear[j - 1] = axis;
            } else {
                linear[j - 1] = cross(axis, point - frames[j].shift);
                angular[j - 1] = axis;
            }
        }
    }
};

// The volume of the box that `count` vectors of `size` numbers span, by modified Gram-Schmidt; they are overwritten.
INLINED void spanned_volume(Four* vectors, int count, int size, Four& volume) {
    volume = Four{} + 1.0;
    for (int i = 0; i < count; ++i) {
        Four *vector = vectors + i * size, square = {};
        for (int k = 0; k < size; ++k) square += vector[k] * vector[k];
        Four norm;
        take_roots(square, norm);
        volume *= norm;
        const Four scale = 1.0 / (norm > 1e-300 ? norm : Four{} + 1e-300);
        for (int k = 0; k < size; ++k) vector[k] *= scale;
        for (int j = i + 1; j < count; ++j) {
            Four *other = vectors + j * size, along = {};
            for (int k = 0; k < size; ++k) along += vector[k] * other[k];
            for (int k = 0; k < size; ++k) other[k] -= along * vector[k];
        }
    }
}

// What a thread needs to compute manipulability.
class ManipulabilityScratch {
   public:
    Four *q, *vectors;               // (dof,), (6 dof,)
    FrameOf<Four>* frames;           // (dof + 1,)
    VecOf<Four> *linear, *angular;  // (dof,)

    ManipulabilityScratch(const ManipulabilityScratch&) = delete;
    explicit ManipulabilityScratch(int dof) : blocks_(13 * dof + 12 * (dof + 1)) {
        q = reinterpret_cast<Four*>(blocks_.data());
        vectors = q + dof;
        frames = reinterpret_cast<FrameOf<Four>*>(vectors + 6 * dof);
        linear = reinterpret_cast<VecOf<Four>*>(frames + dof + 1);
        angular = linear + dof;
    }

   private:
    struct alignas(32) Block {  // a Four alone counts as aligned to 16 where registers are narrow
        double numbers[4];
    };
    std::vector<Block> blocks_;
};

// Yoshikawa's manipulability w of a point that joint `last` carries at the four configurations of the scratch: the
// volume that the first `rows` rows of its Jacobian span, or its columns where these are fewer.
FOR_THIS_PROCESSOR inline void manipulability_of_four(const Chain& chain, int last, Vec tool, int rows,
                                                      ManipulabilityScratch& s, double* w) {
    const int dof = chain.dof();
    chain.place(s.q, s.frames);
    chain.jacobian(s.frames, last, tool, s.linear, s.angular);
    const bool by_row = rows <= dof;
    for (int j = 0; j < dof; ++j) {
        const VecOf<Four> l = s.linear[j], a = s.angular[j];
        const Four column[6] = {l.x, l.y, l.z, a.x, a.y, a.z};
        for (int r = 0; r < rows; ++r) s.vectors[by_row ? r * dof + j : j * rows + r] = column[r];
    }
    Four volume;
    spanned_volume(s.vectors, by_row ? rows : dof, by_row ? dof : rows, volume);
    for (int l = 0; l < 4; ++l) w[l] = volume[l];
}

}  // namespace planner
