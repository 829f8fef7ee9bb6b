// Proofs of path constraints along curves, by the bounds of constraints/tool_bound.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pose_constraints.hpp"
#include "polynomials.hpp"

namespace planner {

// Bounds on the deviation of frames from their chords: distances to joint axes (frames, dof), derivatives of the columns
// of the Jacobian (frames, dof, dof), joints that turn the frames (frames, dof); and derivatives of the slack by position
// and rotation (pieces,). `forgiven` is added to the slack; spans with a deviation below `finest` are not halved.
struct ConstraintBounds {
    const double *reach, *rates, *turns, *per_metre, *per_turn;
    double forgiven, finest;
};

class ConstraintProof {
   public:
    ConstraintProof(const PoseConstraints& keeping, const ConstraintBounds& bounds, int degree)
        : constraints_(keeping), bounds_(bounds), degree_(degree), dof_(keeping.chain.dof()),
          frames_(keeping.chain.size() + 1), q_(dof_), sizes_(dof_), speed_(dof_), bend_(dof_),
          part_((degree + 1) * dof_), slope_((degree + 1) * dof_) {}

    // Whether all constraints hold on the whole curve c (degree + 1, dof).
    bool holds(const double* c) {
        c_ = c;
        add_sizes(c, degree_, sizes_.data());
        for (int k = 0; k < static_cast<int>(constraints_.frames.size()); ++k)
            if (!frame_holds(k)) return false;
        return true;
    }

   private:
    // A span of the curve, with indices into `spare_` of the slack at its ends.
    struct Span {
        double low, high;
        size_t first, last;
    };

    // relative rounding per joint, of placements, joint values and derivatives
    static constexpr double rounded_ = 64 * std::numeric_limits<double>::epsilon();

    // Breadth first, so violations are met early.
    bool frame_holds(int k) {
        reach_ = bounds_.reach + k * dof_, turns_ = bounds_.turns + k * dof_, rates_ = bounds_.rates + k * dof_ * dof_;
        kept_ = &constraints_.frames[k];
        spare_.clear(), open_.clear();
        if (!look(0.0) || !look(1.0)) return false;
        const size_t pieces = kept_->behind - kept_->first;
        open_.push_back({0.0, 1.0, 0, pieces});
        while (!open_.empty()) {
            halves_.clear();
            for (const Span& span : open_) {
                poll_signal_at(rounds_++);
                const Outcome outcome = decide(span);
                if (outcome == kept) continue;
                const double middle = 0.5 * (span.low + span.high);
                const size_t between = spare_.size();
                if (outcome == stuck || !look(middle)) return false;
                halves_.push_back({span.low, middle, span.first, between});
                halves_.push_back({middle, span.high, between, span.last});
            }
            open_.swap(halves_);
        }
        return true;
    }

    // Slack of the frame's constraints at s, less rounding; returns whether all are satisfied.
    bool look(double s) {
        for (int j = 0; j < dof_; ++j) {
            double value = c_[degree_ * dof_ + j];
            for (int k = degree_ - 1; k >= 0; --k) value = value * s + c_[k * dof_ + j];
            q_[j] = value;
        }
        constraints_.chain.place(q_.data(), frames_.data());
        double y[12];
        pose_of(*kept_, frames_.data(), y);
        double off, turned;
        rounding(y, off, turned);
        bool all = true;
        for (int k = kept_->first; k < kept_->behind; ++k) {
            const double noise = off * bounds_.per_metre[k] + turned * bounds_.per_turn[k];
            spare_.push_back(constraints_.slack(constraints_.pieces[k], y) + bounds_.forgiven - noise);
            all = all && spare_.back() >= 0.0;
        }
        return all;
    }

    // Bounds on rounding of a position (m) near y, and of a column of the rotation.
    void rounding(const double* y, double& off, double& turned) const {
        double size = std::fabs(y[0]) + std::fabs(y[1]) + std::fabs(y[2]) + 1.0;
        if (kept_->is_relative()) {  // of both positions in the world
            const Vec at = kept_->base_at(frames_.data()).shift;
            size = 3.0 * size + 2.0 * (std::fabs(at.x) + std::fabs(at.y) + std::fabs(at.z));
        }
        const double count = rounded_ * dof_;
        off = turned = 0.0;
        for (int j = 0; j < dof_; ++j) {
            size += reach_[j];
            off += rounded_ * sizes_[j] * reach_[j];
            turned += rounded_ * sizes_[j] * turns_[j];
        }
        off += count * size, turned += count;
    }

    enum Outcome { kept, open, stuck };

    Outcome decide(const Span& span) {
        double off, turned, most = 0.0;
        leave(span, off, turned);
        bool covered = true, halved = false;
        const size_t pieces = kept_->behind - kept_->first;
        for (size_t k = 0; k < pieces; ++k) {
            const size_t piece = kept_->first + k;
            const double need = off * bounds_.per_metre[piece] + turned * bounds_.per_turn[piece];
            const double least = std::min(spare_[span.first + k], spare_[span.last + k]);
            covered = covered && least - need >= 0.0;
            halved = halved || need > bounds_.finest;
            most = std::max(most, need);
        }
        return covered ? kept : halved && most < HUGE_VAL ? open : stuck;
    }

    // Bounds on the deviation of a frame from its chord on a span: position (m), and column of the rotation.
    void leave(const Span& span, double& off, double& turned) {
        cut(span.low, span.high);
        const int degree = derive(part_.data(), degree_, 1, slope_.data(), dof_);
        largest(slope_.data(), degree, span.high - span.low, speed_.data());
        largest(slope_.data(), derive(slope_.data(), degree, 1, slope_.data(), dof_), span.high - span.low,
                bend_.data());
        double speed = 0.0;
        off = turned = 0.0;
        for (int i = 0; i < dof_; ++i) {
            double row = 0.0;
            for (int k = 0; k < dof_; ++k) row += rates_[i * dof_ + k] * speed_[k];
            off += bend_[i] * reach_[i] + speed_[i] * row;
            turned += bend_[i] * turns_[i];
            speed += speed_[i] * turns_[i];
        }
        off *= 0.125 * (1.0 + rounded_);
        turned = 0.125 * (turned + speed * speed) * (1.0 + rounded_);
    }

    // The curve on [low, high] as one on [0, 1], by its Taylor expansion at low (Horner's scheme).
    void cut(double low, double high) {
        std::copy(c_, c_ + (degree_ + 1) * dof_, part_.begin());
        for (int k = 0; k < degree_; ++k)
            for (int i = degree_ - 1; i >= k; --i)
                for (int j = 0; j < dof_; ++j) part_[i * dof_ + j] += low * part_[(i + 1) * dof_ + j];
        double power = 1.0;
        for (int k = 1; k <= degree_; ++k) {
            power *= high - low;
            for (int j = 0; j < dof_; ++j) part_[k * dof_ + j] *= power;
        }
    }

    // Upper bounds (dof,) on the absolute value of a derivative on a span.
    void largest(const double* c, int degree, double span, double* most) {
        add_sizes(c, degree, most);
        bernstein_.assign(c, c + (degree + 1) * dof_);
        to_bernstein(bernstein_.data(), degree, dof_);
        for (int j = 0; j < dof_; ++j) {
            double top = 0.0;
            for (int k = 0; k <= degree; ++k) top = std::max(top, std::fabs(bernstein_[k * dof_ + j]));
            most[j] = top + rounded_ * (most[j] + sizes_[j] * span);
        }
    }

    // Sums (dof,) of the absolute values of coefficients.
    void add_sizes(const double* c, int degree, double* sums) const {
        std::fill(sums, sums + dof_, 0.0);
        for (int k = 0; k <= degree; ++k)
            for (int j = 0; j < dof_; ++j) sums[j] += std::fabs(c[k * dof_ + j]);
    }

    const PoseConstraints& constraints_;
    const ConstraintBounds bounds_;
    const int degree_, dof_;
    std::vector<Frame> frames_;
    std::vector<double> q_, sizes_, speed_, bend_, part_, slope_, bernstein_, spare_;
    std::vector<Span> open_, halves_;
    const double *c_ = nullptr, *reach_ = nullptr, *rates_ = nullptr, *turns_ = nullptr;
    const ConstrainedFrame* kept_ = nullptr;
    int64_t rounds_ = 0;
};

}  // namespace planner
