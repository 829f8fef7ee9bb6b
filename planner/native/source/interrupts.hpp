// Long calls poll a signal, so that Python handles Ctrl-C during a call.
//
// Python runs signal handlers on its main thread only, between two bytecode instructions. So a call on that thread asks
// Python about ten times a second, and all threads that work for the call read the answer. Long work must reach
// poll_signal() every few milliseconds.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include <pthread.h>

namespace planner {

// Python's answer: continue; finish with undecided results; or leave, as an exception is set.
enum class Signal : int { go_on = 0, finish = 1, leave = 2 };

struct Interrupted {};

// The function that asks Python, and the thread that may call it.
inline std::atomic<Signal (*)()> ask{nullptr};
inline std::atomic<uint64_t> main_thread{0};

// The last answer for a call from Python, shared by the threads that work for it.
struct Call {
    std::atomic<Signal> signal{Signal::go_on};
    std::chrono::steady_clock::time_point next{};
};

inline thread_local Call* current_call = nullptr;

// Scope in which this thread works for a call: a given one, the current one, or else its own.
class Working {
   public:
    Working() : before_(current_call) {
        if (!before_) current_call = &own_;
    }
    explicit Working(Call* call) : before_(current_call) { current_call = call; }
    ~Working() { current_call = before_; }
    Working(const Working&) = delete;

   private:
    Call own_;
    Call* before_;
};

// The signal of the current call, `go_on` or `finish`; throws Interrupted for `leave`.
inline Signal poll_signal() {
    constexpr auto pause = std::chrono::milliseconds(100);
    Call* const call = current_call;
    if (!call) return Signal::go_on;
    Signal signal = call->signal.load(std::memory_order_relaxed);
    if (signal == Signal::go_on && (uint64_t)pthread_self() == main_thread.load(std::memory_order_relaxed)) {
        const auto now = std::chrono::steady_clock::now();
        if (call->next == decltype(now)()) call->next = now + pause;
        if (now >= call->next) {
            const auto asked = ask.load();
            call->signal = signal = asked ? asked() : Signal::go_on;
            call->next = std::chrono::steady_clock::now() + pause;
        }
    }
    if (signal == Signal::leave) throw Interrupted{};
    return signal;
}

// Poll in every 256th round of a loop with short rounds.
inline void poll_signal_at(int64_t round) {
    if (round % 256 == 0) poll_signal();
}

}  // namespace planner
