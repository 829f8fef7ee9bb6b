// Which motions are proven where several would do: the first of alternatives, the cheapest chain through points.
//
// Proofs go on sample by sample where a contact is likeliest, and none goes on once another motion that it needs is
// refused: most of what is tried is refused after two samples, and what is free takes a dozen.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <thread>

#include "prover.hpp"

namespace planner {

// The motion between two states, as a piece (2, dof).
inline void straight_piece(const double* from, const double* to, int dof, double* coefficients) {
    for (int j = 0; j < dof; ++j) coefficients[j] = from[j], coefficients[dof + j] = to[j] - from[j];
}

// Go on with proofs until all motions are free: -1, or the number of the first one that is refused.
inline int first_refused(Prover& prover, const std::vector<Prover::Attempt*>& attempts, double room) {
    for (;;) {
        int next = -1;
        for (size_t k = 0; k < attempts.size(); ++k) {
            if (attempts[k]->proof.verdict != proven_free) return static_cast<int>(k);
            if (attempts[k]->done()) continue;
            if (next < 0 || attempts[k]->next_gap() < attempts[next]->next_gap()) next = static_cast<int>(k);
        }
        if (next < 0) return -1;
        if (heed() == Told::finish) return attempts[next]->left_open(), next;
        prover.go_on(*attempts[next], room);
    }
}

// Whether all pieces from `first` to `last` are proven; then with their `proofs`.
inline bool all_proven(Prover& prover, const Pieces& pieces, int64_t first, int64_t last, double room, Proof* proofs) {
    std::vector<Prover::Attempt> attempts(last - first);
    std::vector<Prover::Attempt*> all;
    for (int64_t piece = first; piece < last; ++piece) {
        prover.begin(attempts[piece - first], pieces, static_cast<int>(piece));
        all.push_back(&attempts[piece - first]);
    }
    if (first_refused(prover, all, room) >= 0) return false;
    for (int64_t piece = first; piece < last; ++piece) proofs[piece] = attempts[piece - first].proof;
    return true;
}

// The first alternative from `begin` to `end` all of whose motions are proven, or -1. The motions of alternative k are
// the pieces from ends[k] to ends[k + 1]; `proofs` are those of the pieces.
inline int first_proven(Prover& prover, const Pieces& pieces, int begin, int end, const int64_t* ends, double room,
                        Proof* proofs) {
    for (int k = begin; k < end; ++k)
        if (all_proven(prover, pieces, ends[k], ends[k + 1], room, proofs)) return k;
    return -1;
}

// The rows of the cheapest chain from the first to the last of k points, by forward price (k, k).
inline std::vector<int> cheapest_chain(const double* price, int k) {
    std::vector<double> total(k, infinity);
    std::vector<int> back(k, 0), rows{k - 1};
    total[0] = 0.0;
    for (int row = 1; row < k; ++row, heed())
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
// Motions from one point to the next are proven already; others are once a cheapest chain has them, which is the lazy
// search of Bohlin and Kavraki (Path planning using lazy PRM, 2000). Those that are refused get an infinite price. Where
// no chain has a finite one, all points are it. Any number of threads may work at it, each with a prover of its own, one
// motion each: which motions are refused when may differ, and what is found is the same.
class ChainSearch {
   public:
    ChainSearch(int count, int dof, const double* points, double* price)
        : count_(count), dof_(dof), points_(points), price_(price), numbers_(static_cast<size_t>(count) * count, -1) {}

    // Work until the chain is found; where one of the threads fails none goes on.
    void work(Prover& prover, double room) {
        try {
            while (!found()) go_on(prover, room);
        } catch (...) {
            const std::lock_guard<Turn> lock(turn_);
            found_ = true;
            throw;
        }
    }

    // The rows of the chain that was found.
    const std::vector<int>& rows() const { return rows_; }

    // The proof of a motion of the chain; of none that was proven before.
    const Proof* proof(int from, int to) const {
        const int number = numbers_[at(from, to)];
        return number < 0 ? nullptr : &motions_[number].attempt.proof;
    }

   private:
    struct Motion {
        size_t place;                      // of its price
        std::vector<double> coefficients;  // (2, dof)
        Prover::Attempt attempt;
        bool busy = false;
    };

    // Whose turn it is: held for less time than it takes to sleep and wake.
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
        if (!found_ && heed() == Told::finish) take_all();
        return found_;
    }

    // One sample more of one motion.
    void go_on(Prover& prover, double room) {
        Motion* motion = nullptr;
        {
            const std::lock_guard<Turn> lock(turn_);
            if (!found_) motion = next(prover);
            if (motion) motion->busy = true;
        }
        if (!motion) return std::this_thread::yield();  // for others to come to the end of a sample
        prover.go_on(motion->attempt, room);
        const std::lock_guard<Turn> lock(turn_);
        motion->busy = false;
        if (motion->attempt.proof.verdict == proven_free) return;
        price_[motion->place] = infinity;
        if (!found_) rows_.clear();
    }

    // The motion of the cheapest chain to go on with; none while others are busy with what is left, or if it is found.
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
    std::vector<int> rows_;       // of the cheapest chain; none once one of its motions is refused
    std::vector<Motion*> chain_;  // its motions that were not proven before
    std::vector<int> numbers_;    // of motions, by their ends
    std::deque<Motion> motions_;
};

}  // namespace planner
