// Waiting threads, shared by all calls of the process, and joined at its end.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include <pthread.h>

namespace planner {

// Work of one call that helpers can share. Guarded by the pool's mutex.
struct Job {
    std::function<void()> help;
    int wanted = 0, busy = 0;  // helpers that can still begin, and that work
    std::condition_variable idle;
};

class Pool {
   public:
    static constexpr int most = 256;  // threads

    // The pool of this process. A forked child has none of its parent's threads, so it makes a new pool.
    static Pool& here() {
        std::call_once(once(), [] { pthread_atfork(nullptr, nullptr, [] { place() = new Pool; }); });
        static const Joiner joiner;
        return *place();
    }

    // Offer a job to up to `helpers` idle threads.
    void offer(const std::shared_ptr<Job>& job, int helpers) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (leaving_) return;
        grow(std::min(helpers, most));
        job->wanted = std::min(helpers, static_cast<int>(threads_.size()));
        if (!job->wanted) return;
        jobs_.push_back(job);
        for (int k = 0; k < job->wanted; ++k) work_.notify_one();
    }

    // Stop new helpers; returns true if no helper works any more, after waiting at most `wait`.
    template <class Duration>
    bool over(const std::shared_ptr<Job>& job, Duration wait) {
        std::unique_lock<std::mutex> lock(mutex_);
        job->wanted = 0;
        jobs_.erase(std::remove(jobs_.begin(), jobs_.end(), job), jobs_.end());
        return job->idle.wait_for(lock, wait, [&] { return !job->busy; });
    }

    // Whether the process ends, so helpers stop.
    bool leaving() const { return leaving_; }

   private:
    struct Joiner {
        ~Joiner() { place()->leave(); }
    };

    static std::once_flag& once() {
        static std::once_flag flag;
        return flag;
    }

    // Never destroyed: threads that outlive the main thread still use it.
    static Pool*& place() {
        static Pool* pool = new Pool;
        return pool;
    }

    void grow(int count) {
        try {
            while (static_cast<int>(threads_.size()) < count) threads_.emplace_back([this] { serve(); });
        } catch (const std::system_error&) {
            // the system has no more threads; the existing ones do the work
        }
    }

    void serve() {
        std::unique_lock<std::mutex> lock(mutex_);
        while (true) {
            work_.wait(lock, [this] { return leaving_ || !jobs_.empty(); });
            if (leaving_) return;
            const std::shared_ptr<Job> job = jobs_.front();
            if (!--job->wanted) jobs_.pop_front();
            ++job->busy;
            lock.unlock();
            job->help();
            lock.lock();
            if (!--job->busy) job->idle.notify_all();
        }
    }

    void leave() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            leaving_ = true;
            jobs_.clear();
        }
        work_.notify_all();
        for (std::thread& thread : threads_) thread.join();
        threads_.clear();
    }

    std::mutex mutex_;
    std::condition_variable work_;
    std::deque<std::shared_ptr<Job>> jobs_;
    std::vector<std::thread> threads_;
    std::atomic<bool> leaving_{false};
};

}  // namespace planner
