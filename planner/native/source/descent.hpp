// Orders of changes to a path by several threads: the result does not depend on the number of threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "interrupts.hpp"

namespace planner {

// Step size of waypoints in a sweep, and the share of waypoints that moved in the previous one.
struct Step {
    double size, moved;

    // The step of the next sweep, after a share of `now` moved: smaller if few gained. That heeds the sweep before the last one:
    // it is over when the next one begins, while the last one may not be.
    Step next(double now) const {
        constexpr double few = 0.3, less = 0.7;
        return {moved < few ? less * size : size, now};
    }
};

// Sweeps over a path of n rows; each sweep moves every second waypoint, alternately.
//
// A waypoint moves between fixed neighbours, after their moves of the previous sweeps. Threads take moves in order and
// wait for these neighbours, so the result does not depend on the threads.
class Sweeps {
   public:
    Sweeps(int n, int first, int sweeps, Step step, double least)
        : n_(n), first_(first), sweeps_(sweeps), least_(least), step_(step), done_(std::max(n, 0)), left_(sweeps),
          moved_(sweeps) {
        for (int sweep = 0; sweep < sweeps; ++sweep) left_[sweep] = waypoints(sweep);
    }

    // The largest number of moves.
    int moves() const { return sweeps_ / 2 * (waypoints(0) + waypoints(1)) + sweeps_ % 2 * waypoints(0); }

    // Do the `item`-th move; work(sweep, waypoint, row, size) returns whether the waypoint moved.
    template <class Work>
    void move(int item, Work work) {
        const int both = waypoints(0) + waypoints(1), late = item % both >= waypoints(0);
        const int sweep = item / both * 2 + late, k = item % both - late * waypoints(0), row = first(sweep) + 2 * k;
        try {
            if (!has_its_turn(sweep, row)) return;
            const double size = step(sweep).size;
            if (size >= least_ && work(sweep, k, row, size)) ++moved_[sweep];
        } catch (...) {
            broken_ = true;
            throw;
        }
        ++done_[row];
        --left_[sweep];
    }

    // The number of sweeps; `next` is the step of the next one.
    int made(double* next) const {
        int sweep = 0;
        while (sweep < sweeps_ && step(sweep).size >= least_) ++sweep;
        const Step last = step(sweep);
        next[0] = last.size, next[1] = last.moved;
        return sweep;
    }

   private:
    int first(int sweep) const { return 1 + (first_ - 1 + sweep) % 2; }
    int waypoints(int sweep) const { return std::max(0, (n_ - first(sweep)) / 2); }

    Step step(int sweep) const {
        Step now = step_;
        for (int before = 0; before < sweep; ++before) {
            const int all = waypoints(before);
            now = now.next(all ? static_cast<double>(moved_[before]) / all : 1.0);
        }
        return now;
    }

    // Wait for the turn of a move; false if a sweep without moves ends the work.
    bool has_its_turn(int sweep, int row) const {
        const int times = (sweep + 1) / 2;  // moves of the neighbours before
        const auto is_done = [&](int beside) { return beside == 0 || beside == n_ - 1 || done_[beside] >= times; };
        while (!(is_done(row - 1) && is_done(row + 1) && (sweep < 2 || left_[sweep - 2] == 0))) {
            if (broken_) return false;
            poll_signal();
            std::this_thread::yield();
        }
        return true;
    }

    int n_, first_, sweeps_;
    double least_;
    Step step_;
    std::vector<std::atomic<int>> done_, left_, moved_;  // by row, and by sweep
    std::atomic<bool> broken_{false};
};

// Attempts that threads compute ahead and apply in order; an attempt computed before a change is repeated. Few attempts
// change anything, so threads hardly wait, and the result does not depend on the threads.
class InTurn {
   public:
    // look() copies the shared state, attempt() works on the copy, take() applies it and returns whether it changed.
    template <class Look, class Attempt, class Take>
    void run(int item, Look look, Attempt attempt, Take take) {
        try {
            int seen;
            {
                const std::lock_guard<std::mutex> lock(mutex_);
                look(), seen = changes_;
            }
            attempt();
            for (; turn_ != item; std::this_thread::yield()) {
                if (broken_) return;
                poll_signal();
            }
            if (seen != changes_) look(), attempt();  // only the thread with the turn changes the state
            {
                const std::lock_guard<std::mutex> lock(mutex_);
                if (take()) ++changes_;
            }
            ++turn_;
        } catch (...) {
            broken_ = true;
            throw;
        }
    }

   private:
    std::mutex mutex_;
    int changes_ = 0;
    std::atomic<int> turn_{0};
    std::atomic<bool> broken_{false};
};

}  // namespace planner
