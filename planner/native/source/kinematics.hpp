// The joint tree of a robot: where its links are, the tool's Jacobian and manipulability.
#pragma once

#include <vector>

#include "vector.hpp"

namespace planner {

constexpr int most_joints = 64;

struct Joint {
    int parent;           // 0 the base, else the number of a joint + 1
    bool prismatic;
    Mat turns[3];         // placement P, P [a], P [a] [a]: Rodrigues' formula
    Vec offset, slide;    // in the parent's frame
    Vec axis;             // in its own frame, which is also the one it turns about in P's frame
};

struct Chain {
    std::vector<Joint> joints;

    int dof() const { return static_cast<int>(joints.size()); }

    // Frames (dof + 1) of the base and all joints at a configuration.
    void place(const double* q, Frame* frames) const {
        frames[0] = Frame();
        for (int j = 0; j < dof(); ++j) {
            const Joint& joint = joints[j];
            const Frame& parent = frames[joint.parent];
            Frame& here = frames[j + 1];
            here.shift = parent * joint.offset;
            if (joint.prismatic) {
                here.shift = here.shift + q[j] * (parent.turn * joint.slide);
                here.turn = parent.turn * joint.turns[0];
                continue;
            }
            double sine = std::sin(q[j]), versine = 1.0 - std::cos(q[j]);
            Mat local;
            for (int k = 0; k < 9; ++k)
                local.m[k] = joint.turns[0].m[k] + sine * joint.turns[1].m[k] + versine * joint.turns[2].m[k];
            here.turn = parent.turn * local;
        }
    }

    // Columns of the Jacobian of a point that joint `last` carries, in world axes: 3 linear rows, then 3 angular ones.
    void jacobian(const Frame* frames, int last, Vec tool, Vec* linear, Vec* angular) const {
        for (int j = 0; j < dof(); ++j) linear[j] = angular[j] = Vec();
        Vec point = frames[last] * tool;
        for (int j = last; j > 0; j = joints[j - 1].parent) {
            const Joint& joint = joints[j - 1];
            Vec axis = frames[j].turn * joint.axis;
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
inline double spanned_volume(double* vectors, int count, int size) {
    double volume = 1.0;
    for (int i = 0; i < count; ++i) {
        double* vector = vectors + i * size;
        double square = 0.0;
        for (int k = 0; k < size; ++k) square += vector[k] * vector[k];
        double norm = std::sqrt(square);
        volume *= norm;
        double scale = 1.0 / (norm > 1e-300 ? norm : 1e-300);
        for (int k = 0; k < size; ++k) vector[k] *= scale;
        for (int j = i + 1; j < count; ++j) {
            double* other = vectors + j * size;
            double along = 0.0;
            for (int k = 0; k < size; ++k) along += vector[k] * other[k];
            for (int k = 0; k < size; ++k) other[k] -= along * vector[k];
        }
    }
    return volume;
}

}  // namespace planner
