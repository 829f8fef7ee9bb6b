// Path constraints: convex sets of poses of frames, their slack, and projection of states onto them.
#pragma once

#include <algorithm>
#include <vector>

#include "inverse.hpp"

namespace planner {

// A constraint on y = (position, rows of the rotation) of a frame: row . y >= limit, or a ball |rows y - centres| <= limit.
// `depth` is the largest slack of the first kind.
struct Piece {
    int first, behind;  // range of its rows
    bool ball;
    double limit, depth;
};

// A frame on a joint, with its constraints from `first` on. Its pose is that in another frame, `base`, on the joint
// `base_joint`, or in the world if that is -1.
struct ConstrainedFrame {
    int joint;
    Frame placement;
    int first, behind;
    int base_joint;
    Frame base;

    bool is_relative() const { return base_joint >= 0; }
    Frame base_at(const Frame* frames) const {
        const Frame& joint = frames[base_joint];
        return {joint.turn * base.turn, joint * base.shift};
    }
};

struct PoseConstraints {
    Chain chain;
    std::vector<ConstrainedFrame> frames;
    std::vector<Piece> pieces;
    std::vector<double> rows, centres;  // (rows, 12), (rows,)
    std::vector<double> lower, upper;   // of joints that do not wrap
    std::vector<uint8_t> wraps;

    double along(int row, const double* y) const {
        double sum = 0.0;
        for (int k = 0; k < 12; ++k) sum += rows[12 * static_cast<size_t>(row) + k] * y[k];
        return sum;
    }

    // Distance of y to the centre of a ball.
    double away(const Piece& piece, const double* y) const {
        double sum = 0.0;
        for (int row = piece.first; row < piece.behind; ++row) {
            const double off = along(row, y) - centres[row];
            sum += off * off;
        }
        return std::sqrt(sum);
    }

    // Slack of a constraint at y; negative if violated.
    double slack(const Piece& piece, const double* y) const {
        return piece.ball ? piece.limit - away(piece, y) : along(piece.first, y) - piece.limit;
    }
};

// Position and rows of the rotation of a frame, from the frames of the chain.
inline void pose_of(const ConstrainedFrame& kept, const Frame* frames, double* y) {
    const Frame& joint = frames[kept.joint];
    Vec position = joint * kept.placement.shift;
    Mat turn = joint.turn * kept.placement.turn;
    if (kept.is_relative()) {
        const Frame base = kept.base_at(frames);
        position = rotate_back(base.turn, position - base.shift);
        Mat back;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) back.m[3 * i + j] = base.turn.m[3 * j + i];
        turn = back * turn;
    }
    y[0] = position.x, y[1] = position.y, y[2] = position.z;
    std::copy(turn.m, turn.m + 9, y + 3);
}

class Projection {
   public:
    explicit Projection(const PoseConstraints& keeping)
        : constraints_(keeping), dof_(keeping.chain.dof()), frames_(keeping.chain.size() + 1), linear_(dof_),
          angular_(dof_), base_linear_(dof_), base_angular_(dof_), rates_(12 * dof_), row_(dof_), square_(dof_ * dof_),
          step_(dof_) {}

    // Gauss-Newton steps from q to the constraints, a share `depth` of the way to their centres, until all hold up to
    // `exact`; q becomes the result. Returns whether all hold.
    bool run(double* q, double depth, double exact, int steps) {
        constexpr double largest_step = 0.5;  // rad, m
        for (int round = 0;; ++round) {
            poll_signal_at(round);
            if (holds(q, exact)) return true;
            if (round == steps) return false;
            look(depth);
            double most = 1e-300;
            for (double part : step_) most = std::max(most, std::fabs(part));
            const double shrunk = std::min(1.0, largest_step / most);
            for (int j = 0; j < dof_; ++j) {
                q[j] -= shrunk * step_[j];
                if (!constraints_.wraps[j])
                    q[j] = std::min(std::max(q[j], constraints_.lower[j]), constraints_.upper[j]);
            }
        }
    }

   private:
    bool holds(const double* q, double exact) {
        constraints_.chain.place(q, frames_.data());
        for (const ConstrainedFrame& kept : constraints_.frames) {
            pose_of(kept, frames_.data(), y_);
            for (int k = kept.first; k < kept.behind; ++k)
                if (!(constraints_.slack(constraints_.pieces[k], y_) >= -exact)) return false;
        }
        return true;
    }

    // The negative of the smallest joint motion that removes all violations, to first order.
    void look(double depth) {
        std::fill(square_.begin(), square_.end(), 0.0);
        std::fill(step_.begin(), step_.end(), 0.0);
        size_ = 0.0;
        for (const ConstrainedFrame& kept : constraints_.frames) {
            pose_of(kept, frames_.data(), y_);
            rates(kept);
            for (int k = kept.first; k < kept.behind; ++k) {
                const Piece& piece = constraints_.pieces[k];
                if (!piece.ball) {
                    const double off = constraints_.slack(piece, y_) - depth * piece.depth;
                    if (off < 0.0) take(piece.first, off);
                    continue;
                }
                const double far = std::max(constraints_.away(piece, y_), 1e-300);
                const double share = 1.0 - (1.0 - depth) * piece.limit / far;
                for (int row = piece.first; share > 0.0 && row < piece.behind; ++row)
                    take(row, share * (constraints_.along(row, y_) - constraints_.centres[row]));
            }
        }
        const double damping = 1e-9 + 1e-3 * size_;
        for (int j = 0; j < dof_; ++j) square_[j * dof_ + j] += damping;
        solve_positive(square_.data(), step_.data(), dof_);
    }

    // Derivative of the pose by each joint (12, dof).
    void rates(const ConstrainedFrame& kept) {
        constraints_.chain.jacobian(frames_.data(), kept.joint, kept.placement.shift, linear_.data(), angular_.data());
        if (kept.is_relative()) subtract_base(kept);
        for (int j = 0; j < dof_; ++j) {
            rates_[j] = linear_[j].x, rates_[dof_ + j] = linear_[j].y, rates_[2 * dof_ + j] = linear_[j].z;
            for (int column = 0; column < 3; ++column) {
                const Vec turned = cross(angular_[j], Vec{y_[3 + column], y_[6 + column], y_[9 + column]});
                rates_[(3 + column) * dof_ + j] = turned.x, rates_[(6 + column) * dof_ + j] = turned.y;
                rates_[(9 + column) * dof_ + j] = turned.z;
            }
        }
    }

    // Make the Jacobian one in the base frame, relative to it.
    void subtract_base(const ConstrainedFrame& kept) {
        constraints_.chain.jacobian(frames_.data(), kept.base_joint, kept.base.shift, base_linear_.data(),
                                    base_angular_.data());
        const Frame base = kept.base_at(frames_.data());
        const Vec apart = frames_[kept.joint] * kept.placement.shift - base.shift;
        for (int j = 0; j < dof_; ++j) {
            const Vec moved = linear_[j] - base_linear_[j] - cross(base_angular_[j], apart);
            linear_[j] = rotate_back(base.turn, moved);
            angular_[j] = rotate_back(base.turn, angular_[j] - base_angular_[j]);
        }
    }

    // Add a row to the least-squares problem.
    void take(int row, double off) {
        size_ += off * off;
        std::fill(row_.begin(), row_.end(), 0.0);
        for (int k = 0; k < 12; ++k) {
            const double weight = constraints_.rows[12 * static_cast<size_t>(row) + k];
            if (weight != 0.0)
                for (int j = 0; j < dof_; ++j) row_[j] += weight * rates_[k * dof_ + j];
        }
        for (int i = 0; i < dof_; ++i) {
            step_[i] += row_[i] * off;
            for (int j = 0; j < dof_; ++j) square_[i * dof_ + j] += row_[i] * row_[j];
        }
    }

    const PoseConstraints& constraints_;
    int dof_;
    double y_[12] = {}, size_ = 0.0;
    std::vector<Frame> frames_;
    std::vector<Vec> linear_, angular_, base_linear_, base_angular_;
    std::vector<double> rates_, row_, square_, step_;
};

}  // namespace planner
