// Long calls ask now and then whether they are to go on, so that Python hears Ctrl-C while they last.
//
// Python runs the handlers of signals on its main thread alone, and there only between two of its own instructions. So a
// call that was made on that thread goes back to Python some ten times a second, and whatever works for it looks at what
// it was told. heed() has to be reached every few milliseconds by all that can take long.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include <pthread.h>

namespace planner {

// What Python says: go on; come to an end, and say of what is not done that it is undecided; or an exception is waiting.
enum class Told : int { go_on = 0, finish = 1, leave = 2 };

struct Interrupted {};

// Whom to ask, on which thread.
inline std::atomic<Told (*)()> ask{nullptr};
inline std::atomic<uint64_t> main_thread{0};

// What a call from Python was told; threads that work for it look at it too.
struct Call {
    std::atomic<Told> told{Told::go_on};
    std::chrono::steady_clock::time_point next{};
};

inline thread_local Call* current_call = nullptr;

// While there is one, this thread works for a call: one of its own, unless it works for one already, or another's.
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

// What the call at hand was told, `go_on` or `finish`; throws Interrupted where it is to leave.
inline Told heed() {
    constexpr auto pause = std::chrono::milliseconds(100);
    Call* const call = current_call;
    if (!call) return Told::go_on;
    Told told = call->told.load(std::memory_order_relaxed);
    if (told == Told::go_on && (uint64_t)pthread_self() == main_thread.load(std::memory_order_relaxed)) {
        const auto now = std::chrono::steady_clock::now();
        if (call->next == decltype(now)()) call->next = now + pause;
        if (now >= call->next) {
            const auto asked = ask.load();
            call->told = told = asked ? asked() : Told::go_on;
            call->next = std::chrono::steady_clock::now() + pause;
        }
    }
    if (told == Told::leave) throw Interrupted{};
    return told;
}

// The same in a loop whose rounds take no time: in every 256th of them.
inline void heed_at(int64_t round) {
    if (round % 256 == 0) heed();
}

}  // namespace planner
