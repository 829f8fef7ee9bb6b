// Work that is shared among threads.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <memory>

#include "flows.hpp"
#include "interrupts.hpp"
#include "pool.hpp"

namespace planner {

// Do `work(k, worker)` for k in [0, count) on up to `threads` threads; `make` makes what each of them works in.
// Whatever the threads, every k is worked on alone: the results are the same. No thread is waited for that has not
// begun: on a busy machine that takes longer than the work.
template <class Make, class Work>
void share_out(int count, int threads, int least, Make make, Work work) {
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
    const int helpers = std::min(threads - 1, (count - 1) / std::max(least, 1));
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
void share_out_rows(int64_t rows, int threads, Work work) {
    const int blocks = static_cast<int>((rows + flow_block - 1) / flow_block);
    share_out(
        blocks, threads, 32, [] { return 0; },
        [&](int b, int) { work(int64_t{b} * flow_block, std::min(int64_t{b + 1} * flow_block, rows), b); });
}

}  // namespace planner
