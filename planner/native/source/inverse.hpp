// Inverse kinematics by damped least squares (Wampler 1986; Nakamura and Hanafusa 1986).
#pragma once

#include <algorithm>
#include <vector>

#include "kinematics.hpp"

namespace planner {

// The rotation vector of a rotation: its axis times its angle, at most pi.
inline Vec rotation_vector(const Mat& r) {
    // as a quaternion (w, x, y, z), from its largest entry, to avoid cancellation
    const double* m = r.m;
    const double four[4] = {1 + m[0] + m[4] + m[8], 1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8],
                            1 - m[0] - m[4] + m[8]};
    const int largest = static_cast<int>(std::max_element(four, four + 4) - four);
    const double x = m[7] - m[5], y = m[2] - m[6], z = m[3] - m[1];
    const double xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
    const double rows[4][4] = {{four[0], x, y, z}, {x, four[1], xy, xz}, {y, xy, four[2], yz}, {z, xz, yz, four[3]}};
    const double* q = rows[largest];
    const double sign = q[0] < 0.0 ? -1.0 : 1.0;
    const Vec v{sign * q[1], sign * q[2], sign * q[3]};
    const double sine = length(v), cosine = sign * q[0];
    const double scale = sine > 1e-300 ? 2.0 * std::atan2(sine, cosine) / sine : 0.0;
    return scale * v;
}

// Derivative of the rotation vector for a rotation by `turned` in the body frame (Chirikjian 2012).
inline Vec rotation_vector_rate(Vec vector, Vec turned) {
    const double angle = length(vector);
    const double share = angle < 1e-4
                             ? 1.0 / 12.0 + angle * angle / 720.0
                             : (1.0 - 0.5 * angle * std::cos(0.5 * angle) / std::sin(0.5 * angle)) / (angle * angle);
    const Vec once = cross(vector, turned);
    return turned + 0.5 * once + share * cross(vector, once);
}

// Solve a x = b for symmetric, positive definite a (n, n) by Cholesky; a is overwritten, b becomes x.
inline void solve_positive(double* a, double* b, int n) {
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j <= i; ++j) {
            double sum = a[i * n + j];
            for (int k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
            a[i * n + j] = i == j ? std::sqrt(std::max(sum, 1e-300)) : sum / a[j * n + j];
        }
        for (int k = 0; k < i; ++k) b[i] -= a[i * n + k] * b[k];
        b[i] /= a[i * n + i];
    }
    for (int i = n - 1; i >= 0; --i) {
        for (int k = i + 1; k < n; ++k) b[i] -= a[k * n + i] * b[k];
        b[i] /= a[i * n + i];
    }
}

// A tool at a point (3 rows), at a frame (6), or at a frame free to turn about z (5).
struct PlacedTool {
    int last;     // its joint
    Frame frame;  // in the frame of this joint
    int rows;
};

// A task of inverse kinematics for all tools at once. Limits (dof,); joints that wrap have none.
struct Task {
    const Chain& chain;
    std::vector<PlacedTool> tools;
    double weight;  // of a metre against a radian
    const double *lower, *upper;
    const uint8_t* wraps;
};

class Descent {
   public:
    explicit Descent(const Task& task)
        : task_(task), dof_(task.chain.dof()), rows_(0), frames_(task.chain.size() + 1), linear_(dof_), angular_(dof_),
          moved_(dof_) {
        for (const PlacedTool& tool : task.tools) rows_ += tool.rows;
        jacobian_.resize(rows_ * dof_), there_.resize(rows_ * dof_), square_.resize(rows_ * rows_), step_.resize(rows_);
        error_.resize(rows_), error_there_.resize(rows_);
    }

    // Levenberg-Marquardt from q to targets in the world, one for each tool; q becomes the result. A step that does not
    // reduce the error increases the damping.
    void run(double* q, const std::vector<Frame>& targets, int iterations) {
        targets_ = targets;
        constexpr double largest_step = 0.5, near = 1e-7, hopeless = 1e6;  // rad, m or rad
        double damping = 1e-3, size = look(q, error_.data(), jacobian_.data());
        for (int round = 0; round < iterations && size >= near * near && damping <= hopeless; ++round) {
            poll_signal_at(round);
            double most = 1e-12;
            for (int i = 0; i < rows_; ++i)
                for (int k = 0; k < rows_; ++k) {
                    double sum = i == k ? damping + 1e-14 : 0.0;
                    for (int j = 0; j < dof_; ++j) sum += jacobian_[i * dof_ + j] * jacobian_[k * dof_ + j];
                    square_[i * rows_ + k] = sum;
                }
            for (int i = 0; i < rows_; ++i) step_[i] = -error_[i];
            solve_positive(square_.data(), step_.data(), rows_);
            for (int j = 0; j < dof_; ++j) {
                moved_[j] = 0.0;
                for (int i = 0; i < rows_; ++i) moved_[j] += jacobian_[i * dof_ + j] * step_[i];
                most = std::max(most, std::fabs(moved_[j]));
            }
            const double shrunk = std::min(1.0, largest_step / most);
            for (int j = 0; j < dof_; ++j) {
                moved_[j] = q[j] + shrunk * moved_[j];
                if (!task_.wraps[j]) moved_[j] = std::min(std::max(moved_[j], task_.lower[j]), task_.upper[j]);
            }
            const double size_there = look(moved_.data(), error_there_.data(), there_.data());
            if (size_there < size) {
                std::copy(moved_.begin(), moved_.end(), q);
                error_.swap(error_there_), jacobian_.swap(there_);
                size = size_there, damping *= 0.1;
            } else {
                damping = std::max(10.0 * damping, 1e-6);
            }
        }
    }

    // Largest distance (m) of a tool to its target at q, and angle (rad) of a tool, or of its z axis.
    void miss(const double* q, double& distance, double& angle) {
        task_.chain.place(q, frames_.data());
        distance = angle = 0.0;
        for (size_t k = 0; k < targets_.size(); ++k) {
            const PlacedTool& tool = task_.tools[k];
            const Frame& joint = frames_[tool.last];
            distance = std::max(distance, length(joint * tool.frame.shift - targets_[k].shift));
            if (tool.rows == 3) continue;
            const Mat turn = rotation_between(targets_[k], joint.turn * tool.frame.turn);
            angle = std::max(angle, tool.rows == 6 ? length(rotation_vector(turn))
                                                   : std::atan2(std::hypot(turn.m[2], turn.m[5]), turn.m[8]));
        }
    }

   private:
    // Rotation from the target to the tool.
    static Mat rotation_between(const Frame& target, const Mat& tool) {
        Mat back;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) back.m[3 * i + j] = target.turn.m[3 * j + i];
        return back * tool;
    }

    // The weighted errors at q in the target frames, their Jacobian (rows, dof); returns the square of the error.
    double look(const double* q, double* error, double* jacobian) {
        task_.chain.place(q, frames_.data());
        for (size_t k = 0, row = 0; k < targets_.size(); row += task_.tools[k++].rows)
            look_at(task_.tools[k], targets_[k], error + row, jacobian + row * dof_);
        double size = 0.0;
        for (int i = 0; i < rows_; ++i) size += error[i] * error[i];
        return size;
    }

    void look_at(const PlacedTool& tool, const Frame& target, double* error, double* jacobian) {
        task_.chain.jacobian(frames_.data(), tool.last, tool.frame.shift, linear_.data(), angular_.data());
        const Frame& joint = frames_[tool.last];
        const Mat turn = joint.turn * tool.frame.turn;
        const Vec apart = task_.weight * rotate_back(target.turn, joint * tool.frame.shift - target.shift);
        const Vec vector = tool.rows > 3 ? rotation_vector(rotation_between(target, turn)) : Vec{};
        const double errors[6] = {apart.x, apart.y, apart.z, vector.x, vector.y, vector.z};
        std::copy(errors, errors + tool.rows, error);  // 5 rows omit the last one
        for (int j = 0; j < dof_; ++j) {
            const Vec column = task_.weight * rotate_back(target.turn, linear_[j]);
            const Vec rate = tool.rows > 3 ? rotation_vector_rate(vector, rotate_back(turn, angular_[j])) : Vec{};
            const double entries[6] = {column.x, column.y, column.z, rate.x, rate.y, rate.z};
            for (int i = 0; i < tool.rows; ++i) jacobian[i * dof_ + j] = entries[i];
        }
    }

    const Task& task_;
    std::vector<Frame> targets_;
    int dof_, rows_;
    std::vector<Frame> frames_;
    std::vector<Vec> linear_, angular_;
    std::vector<double> moved_, jacobian_, there_, square_, step_, error_, error_there_;
};

}  // namespace planner
