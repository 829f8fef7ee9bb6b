// Proofs of many neighbouring curves, such as the pieces of one motion, by boxes of configurations.
//
// A straight piece along the diagonal of a box moves every joint as far from the middle as any state of the box. So a
// sample in the middle that clears a pair on this piece clears it in the whole box. Distant pairs are cleared for many
// curves at once, and single curves are proven for the remaining pairs only.
#pragma once

#include <tuple>

#include "prover.hpp"

namespace planner {

class BoxProof {
   public:
    // `spans` (pieces,) for moving obstacles, or null; results are written to `proofs` (pieces,).
    BoxProof(Prover& prover, const Pieces& pieces, const Span* spans, double resolution, Proof* proofs)
        : prover_(prover), pieces_(pieces), spans_(spans), resolution_(resolution), proofs_(proofs),
          low_(static_cast<size_t>(pieces.count) * pieces.dof), high_(low_.size()) {
        for (int k = 0; k < pieces.count; ++k) measure(k);
    }

    // Prove the curves [first, last) in order, until one is not free; later curves are undecided. `left` are the pairs
    // to prove, all if null. Returns whether all curves are free.
    bool prove(int first, int last, const std::vector<Prover::Task>* left = nullptr) {
        if (last - first == 1) return prove_alone(first, left);
        const std::vector<Prover::Task> still = find_open_tasks(first, last, left);
        if (still.empty() && !leave_reach(first, last)) {
            for (int k = first; k < last; ++k) proofs_[k].samples = 0;
            return true;
        }
        const int middle = (first + last) / 2;
        if (prove(first, middle, &still)) return prove(middle, last, &still);
        for (int k = middle; k < last; ++k) proofs_[k].verdict = undecided;
        return false;
    }

   private:
    bool leave_reach(int first, int last) const {
        for (int k = first; k < last; ++k)
            if (prover_.leaves_reach(pieces_, k)) return true;
        return false;
    }

    void measure(int k) {
        for (int j = 0; j < pieces_.dof; ++j) {
            const size_t at = static_cast<size_t>(k) * pieces_.dof + j;
            std::tie(low_[at], high_[at]) = pieces_.hull(k, j);
        }
    }

    bool prove_alone(int k, const std::vector<Prover::Task>* left) {
        Prover::Attempt attempt;
        prover_.begin(attempt, pieces_, k, spans_ ? spans_ + k : nullptr);
        if (left) {
            attempt.tasks = *left;
            for (Prover::Interval& one : attempt.open) one.last = static_cast<int>(left->size());
        }
        while (!attempt.done()) {
            if (poll_signal() == Signal::finish)
                attempt.left_open();
            else
                prover_.go_on(attempt, resolution_);
        }
        proofs_[k] = attempt.proof;
        return attempt.proof.verdict == proven_free;
    }

    // The pairs that a sample does not clear for the common box of the curves [first, last) and their common time.
    std::vector<Prover::Task> find_open_tasks(int first, int last, const std::vector<Prover::Task>* left) {
        const int dof = pieces_.dof;
        std::vector<double> diagonal(2 * static_cast<size_t>(dof));
        for (int j = 0; j < dof; ++j) {
            double low = infinity, high = -infinity;
            for (int k = first; k < last; ++k) {
                low = std::min(low, low_[static_cast<size_t>(k) * dof + j]);
                high = std::max(high, high_[static_cast<size_t>(k) * dof + j]);
            }
            diagonal[j] = low, diagonal[dof + j] = high - low;
        }
        double begin = infinity, end = -infinity;
        for (int k = first; spans_ && k < last; ++k) {
            begin = std::min(begin, spans_[k].begin - spans_[k].slack);
            end = std::max(end, spans_[k].at(1.0) + spans_[k].slack);
        }
        const Span all{begin, end - begin, 0.0};
        Prover::Attempt attempt;
        attempt.pieces = {diagonal.data(), 1, 1, dof}, attempt.span = spans_ ? &all : nullptr;
        attempt.is_box = true;
        if (left) attempt.tasks = *left;
        const int known = static_cast<int>(attempt.tasks.size());
        attempt.open.push_back({0.0, 1.0, 0.0, 0, known});
        prover_.go_on(attempt, resolution_);
        return {attempt.tasks.begin() + known, attempt.tasks.end()};
    }

    Prover& prover_;
    const Pieces pieces_;
    const Span* spans_;
    double resolution_;
    Proof* proofs_;
    std::vector<double> low_, high_;  // (pieces, dof) interval of each joint
};

}  // namespace planner
