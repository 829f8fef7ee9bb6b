// Proofs of alternatives: the first proven alternative, and the cheapest proven chain through points.
//
// Each step takes the next sample of the motion with the smallest distance. A refused motion ends the proofs of its
// alternative: most motions are refused after two samples, and free ones take a dozen.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <thread>

#include "prover.hpp"

namespace planner {

// Write the motion between two states as a piece (2, dof).
inline void straight_piece(const double* from, const double* to, int dof, double* coefficients) {
    for (int j = 0; j < dof; ++j) coefficients[j] = from[j], coefficients[dof + j] = to[j] - from[j];
}

// Continue proofs until all motions are free; returns -1, or the number of the first refused motion.
inline int find_refused(Prover& prover, const std::vector<Prover::Attempt*>& attempts, double resolution) {
    for (;;) {
        int next = -1;
        for (size_t k = 0; k < attempts.size(); ++k) {
            if (attempts[k]->proof.verdict != proven_free) return static_cast<int>(k);
            if (attempts[k]->done()) continue;
            if (next < 0 || attempts[k]->next_gap() < attempts[next]->next_gap()) next = static_cast<int>(k);
        }
        if (next < 0) return -1;
        if (poll_signal() == Signal::finish) return attempts[next]->left_open(), next;
        prover.go_on(*attempts[next], resolution);
    }
}

// Prove the pieces [first, last); returns whether all are free, with their `proofs`.
inline bool prove_all(Prover& prover, const Pieces& pieces, int64_t first, int64_t last, double resolution,
                      Proof* proofs) {
    std::vector<Prover::Attempt> attempts(last - first);
    std::vector<Prover::Attempt*> all;
    for (int64_t piece = first; piece < last; ++piece) {
        prover.begin(attempts[piece - first], pieces, static_cast<int>(piece));
        all.push_back(&attempts[piece - first]);
    }
    if (find_refused(prover, all, resolution) >= 0) return false;
    for (int64_t piece = first; piece < last; ++piece) proofs[piece] = attempts[piece - first].proof;
    return true;
}

// The first alternative in [begin, end) with all motions proven, or -1. Alternative k has the pieces [ends[k],
// ends[k + 1]); `proofs` are per piece.
inline int first_proven(Prover& prover, const Pieces& pieces, int begin, int end, const int64_t* ends,
                        double resolution, Proof* proofs) {
    for (int k = begin; k < end; ++k)
        if (prove_all(prover, pieces, ends[k], ends[k + 1], resolution, proofs)) return k;
    return -1;
}

// Rows of the cheapest chain from the first to the last of k points, for prices (k, k) of forward motions.
inline std::vector<int> cheapest_chain(const double* price, int k) {
    std::vector<double> total(k, infinity);
    std::vector<int> back(k, 0), rows{k - 1};
    total[0] = 0.0;
    for (int row = 1; row < k; ++row, poll_signal())
        for (int from = 0; from < row; ++from) {
            const double reached = total[from] + price[static_cast<size_t>(from) * k + row];
            if (reached < total[row]) total[row] = reached, back[row] = from;
        }
    while (rows.back() > 0) rows.push_back(back[rows.back()]);
    std::reverse(rows.begin(), rows.end());
    return rows;
}

// The cheapest chain of proven straight motions through some of k points (k, dof), from the first to the last.
//
// Motions between consecutive points are already proven; others are proven when a cheapest chain uses them, as in the
// lazy search of Bohlin and Kavraki (Path planning using lazy PRM, 2000). A refused motion gets an infinite price. If no
// chain has a finite price, the result has all points. Several threads can work at once, each with its own prover and
// motion: the order of refusals can differ, the result does not.
class ChainSearch {
   public:
    ChainSearch(int count, int dof, const double* points, double* price)
        : count_(count), dof_(dof), points_(points), price_(price), numbers_(static_cast<size_t>(count) * count, -1) {}

    // Work until the chain is proven; an exception in one thread stops all.
    void work(Prover& prover, double resolution) {
        try {
            while (!found()) go_on(prover, resolution);
        } catch (...) {
            const std::lock_guard<Turn> lock(turn_);
            found_ = true;
            throw;
        }
    }

    // Rows of the resulting chain.
    const std::vector<int>& rows() const { return rows_; }

    // The proof of a motion of the chain; null for motions between consecutive points.
    const Proof* proof(int from, int to) const {
        const int number = numbers_[at(from, to)];
        return number < 0 ? nullptr : &motions_[number].attempt.proof;
    }

   private:
    struct Motion {
        size_t place;                      // index of its price
        std::vector<double> coefficients;  // (2, dof)
        Prover::Attempt attempt;
        bool busy = false;
    };

    // A spin lock: held for less time than a thread takes to sleep and wake.
    class Turn {
       public:
        void lock() {
            while (taken_.test_and_set(std::memory_order_acquire)) std::this_thread::yield();
        }
        void unlock() { taken_.clear(std::memory_order_release); }

       private:
        std::atomic_flag taken_ = ATOMIC_FLAG_INIT;
    };

    bool found() {
        const std::lock_guard<Turn> lock(turn_);
        if (!found_ && poll_signal() == Signal::finish) take_all();
        return found_;
    }

    // Take the next sample of one motion.
    void go_on(Prover& prover, double resolution) {
        Motion* motion = nullptr;
        {
            const std::lock_guard<Turn> lock(turn_);
            if (!found_) motion = next(prover);
            if (motion) motion->busy = true;
        }
        if (!motion) return std::this_thread::yield();  // other threads finish their samples
        prover.go_on(motion->attempt, resolution);
        const std::lock_guard<Turn> lock(turn_);
        motion->busy = false;
        if (motion->attempt.proof.verdict == proven_free) return;
        price_[motion->place] = infinity;
        if (!found_) rows_.clear();
    }

    // The next motion to sample; null if other threads sample the remaining ones, or the chain is proven.
    Motion* next(Prover& prover) {
        while (rows_.empty()) {
            rows_ = cheapest_chain(price_, count_), chain_.clear();
            if (!finite()) return take_all(), nullptr;
            for (size_t k = 1; k < rows_.size(); ++k)
                if (rows_[k] != rows_[k - 1] + 1) chain_.push_back(motion(prover, rows_[k - 1], rows_[k]));
            for (const Motion* motion : chain_)
                if (motion->attempt.proof.verdict != proven_free) price_[motion->place] = infinity, rows_.clear();
        }
        Motion* best = nullptr;
        found_ = true;
        for (Motion* motion : chain_) {
            if (motion->busy) found_ = false;
            if (motion->busy || motion->attempt.done()) continue;
            found_ = false;
            if (!best || motion->attempt.next_gap() < best->attempt.next_gap()) best = motion;
        }
        return best;
    }

    void take_all() {
        rows_.resize(count_);
        std::iota(rows_.begin(), rows_.end(), 0);
        found_ = true;
    }

    bool finite() const {
        for (size_t k = 1; k < rows_.size(); ++k)
            if (!(price_[at(rows_[k - 1], rows_[k])] < infinity)) return false;
        return true;
    }

    size_t at(int from, int to) const { return static_cast<size_t>(from) * count_ + to; }

    Motion* motion(Prover& prover, int from, int to) {
        int& number = numbers_[at(from, to)];
        if (number < 0) {
            number = static_cast<int>(motions_.size());
            motions_.emplace_back();
            Motion& motion = motions_.back();
            motion.place = at(from, to);
            motion.coefficients.resize(2 * dof_);
            straight_piece(points_ + from * dof_, points_ + to * dof_, dof_, motion.coefficients.data());
            prover.begin(motion.attempt, {motion.coefficients.data(), 1, 1, dof_}, 0);
        }
        return &motions_[number];
    }

    int count_, dof_;
    const double* points_;
    double* price_;
    Turn turn_;
    bool found_ = false;
    std::vector<int> rows_;       // of the cheapest chain; empty after a refusal
    std::vector<Motion*> chain_;  // its motions that need a proof
    std::vector<int> numbers_;    // number of each motion by its ends
    std::deque<Motion> motions_;
};

}  // namespace planner
