// Work that is shared among threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <system_error>
#include <thread>

#include "flows.hpp"
#include "interrupts.hpp"

namespace planner {

// What is left to do, how many threads are at it, and what stopped the first that failed.
struct Shares {
    std::atomic<int> next{0}, busy{0};
    std::atomic<bool> failed{false};
    std::exception_ptr failure;
};

// Do `work(k, worker)` for k in [0, count) on up to `threads` threads; `make` makes what each of them works in.
// Whatever the threads, every k is worked on alone: the results are the same. No thread is waited for that has not
// begun: on a busy machine that takes longer than the work. Such a late one finds nothing left to do, and all that it
// looks at are the shares, which live as long as it does.
template <class Make, class Work>
void share_out(int count, int threads, int least, Make make, Work work) {
    const auto shares = std::make_shared<Shares>();
    const auto fail = [shares, count] {
        if (!shares->failed.exchange(true)) shares->failure = std::current_exception();
        shares->next = count;  // nothing is left to do
    };
    const auto help = [shares, count, fail, call = current_call, &make, &work] {
        ++shares->busy;
        try {
            int k = shares->next++;
            if (k < count) {
                const Working working(call);
                auto worker = make();
                for (; k < count; k = shares->next++) heed(), work(k, worker);
            }
        } catch (...) {
            fail();
        }
        --shares->busy;
    };
    try {
        for (int t = 1; t < threads && t * least < count; ++t) std::thread(help).detach();
    } catch (const std::system_error&) {
        // no more threads are to be had: those that there are do it
    }
    help();
    while (shares->busy > 0) {
        try {
            heed();
        } catch (...) {
            fail();
        }
        std::this_thread::yield();
    }
    if (shares->failed) std::rethrow_exception(shares->failure);
}

// The same for the rows [begin, end) of many blocks of `flow_block` rows.
template <class Work>
void share_out_rows(int64_t rows, int threads, Work work) {
    const int blocks = static_cast<int>((rows + flow_block - 1) / flow_block);
    share_out(blocks, threads, 32, [] { return 0; }, [&](int b, int) {
        work(int64_t{b} * flow_block, std::min(int64_t{b + 1} * flow_block, rows), b);
    });
}

}  // namespace planner
