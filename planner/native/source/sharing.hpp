// Work that is shared among threads.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>

#include <sched.h>

#include "flows.hpp"
#include "interrupts.hpp"
#include "pool.hpp"

namespace planner {

inline std::atomic<int> most_threads{0};  // as many as there are processors where it is 0

// How many threads work is shared among.
inline int threads() {
    if (const int most = most_threads) return most;
#ifdef __linux__
    cpu_set_t allowed;
    if (!sched_getaffinity(0, sizeof allowed, &allowed)) return CPU_COUNT(&allowed);
#endif
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Do `work(k, worker)` for k in [0, count) on some threads; `make` makes what each of them works in. Whatever the
// threads, every k is worked on alone: the results are the same. No thread is waited for that has not begun: on a busy
// machine that takes longer than the work.
template <class Make, class Work>
void share_out(int count, int least, Make make, Work work, int most = threads()) {
    std::atomic<int> next{0};
    std::atomic<bool> failed{false};
    std::exception_ptr failure;
    const auto fail = [&] {
        if (!failed.exchange(true)) failure = std::current_exception();
        next = count;  // nothing is left to do
    };
    const auto begin = [&](Call* call, const auto& stopped) {
        try {
            int k = stopped() ? count : next++;
            if (k >= count) return;
            const Working working(call);
            auto worker = make();
            for (; k < count; k = stopped() ? count : next++) heed(), work(k, worker);
        } catch (...) {
            fail();
        }
    };
    const int helpers = std::min(most - 1, (count - 1) / std::max(least, 1));
    if (helpers > 0) {
        Pool& pool = Pool::here();
        const auto job = std::make_shared<Job>();
        job->help = [&, call = current_call] { begin(call, [&] { return pool.leaving(); }); };
        pool.offer(job, helpers);
        begin(current_call, [] { return false; });
        while (!pool.over(job, std::chrono::milliseconds(20))) {
            try {
                heed();
            } catch (...) {
                fail();
            }
        }
    } else {
        begin(current_call, [] { return false; });
    }
    if (failed) std::rethrow_exception(failure);
}

// The same for the rows [begin, end) of many blocks of `flow_block` rows.
template <class Work>
void share_out_rows(int64_t rows, Work work) {
    constexpr int64_t shared_from = 16384;  // rows from which a thread more gains more than it costs to start
    const int blocks = static_cast<int>((rows + flow_block - 1) / flow_block);
    share_out(
        blocks, 32, [] { return 0; },
        [&](int b, int) { work(int64_t{b} * flow_block, std::min(int64_t{b + 1} * flow_block, rows), b); },
        rows >= shared_from ? threads() : 1);
}

}  // namespace planner
