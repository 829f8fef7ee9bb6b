// What Python calls: plain C functions over arrays of doubles. What returns nothing else returns 0. Numbers and indices
// are looked at here, as refusals.hpp has it, the lengths of arrays by the classes and functions in Python.

#include "calls/chunk.hpp"
#include "calls/dynamics.hpp"
#include "calls/graph.hpp"
#include "calls/motion.hpp"
#include "calls/refinement.hpp"
#include "calls/robot.hpp"
#include "calls/world.hpp"

extern "C" {

int planner_version() { return 35; }

// Whom to ask whether a long call is to go on, see interrupts.hpp, and on which thread; nobody where that is null.
void planner_ask(int (*asked)(), uint64_t thread) {
    planner::main_thread = thread;
    planner::ask = asked;
}

// Why the last call of this thread was refused.
const char* planner_refusal() { return planner::refusal; }

}  // extern "C"
