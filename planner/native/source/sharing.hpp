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

inline std::atomic<int> most_threads{0};  // 0: one per processor

// Number of threads that share work.
inline int threads() {
    if (const int most = most_threads) return most;
#ifdef __linux__
    cpu_set_t allowed;
    if (!sched_getaffinity(0, sizeof allowed, &allowed)) return CPU_COUNT(&allowed);
#endif
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Do `work(k, worker)` for k in [0, count) on some threads; `make` makes the worker of each thread. Each k is independent,
// so results do not depend on the threads. The call does not wait for threads that have not begun: on a busy machine
// that takes longer than the work.
template <class Make, class Work>
void share_out(int count, int least, Make make, Work work, int most = threads()) {
    std::atomic<int> next{0};
    std::atomic<bool> failed{false};
    std::exception_ptr failure;
    const auto fail = [&] {
        if (!failed.exchange(true)) failure = std::current_exception();
        next = count;  // other threads stop
    };
    const auto begin = [&](Call* call, const auto& stopped) {
        try {
            int k = stopped() ? count : next++;
            if (k >= count) return;
            const Working working(call);
            auto worker = make();
            for (; k < count; k = stopped() ? count : next++) poll_signal(), work(k, worker);
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
                poll_signal();
            } catch (...) {
                fail();
            }
        }
    } else {
        begin(current_call, [] { return false; });
    }
    if (failed) std::rethrow_exception(failure);
}

// Share rows in blocks of `flow_block` rows, work(begin, end, block).
template <class Work>
void share_out_rows(int64_t rows, Work work) {
    constexpr int64_t shared_from = 16384;  // rows per thread that outweigh its start
    const int blocks = static_cast<int>((rows + flow_block - 1) / flow_block);
    share_out(
        blocks, 32, [] { return 0; },
        [&](int b, int) { work(int64_t{b} * flow_block, std::min(int64_t{b + 1} * flow_block, rows), b); },
        rows >= shared_from ? threads() : 1);
}

}  // namespace planner
