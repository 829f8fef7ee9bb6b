// The compiled module: functions and classes over NumPy's arrays. Calls check numbers and indices; nanobind checks types
// and shapes.

#include "dynamics.hpp"
#include "gate.hpp"
#include "graph.hpp"
#include "motion.hpp"
#include "refinement.hpp"
#include "robot.hpp"
#include "world.hpp"

namespace {

using namespace planner;

// Answer a call on the main thread: run signal handlers, then call Python functions that may request a stop.
Signal asked() {
    const nb::gil_scoped_acquire held;
    if (PyErr_CheckSignals()) return Signal::leave;  // the exception of a handler is set in this thread
    try {
        for (const nb::handle request : nb::module_::import_("planner.base.interrupts").attr("stop_requests"))
            if (nb::cast<bool>(request())) return Signal::finish;
    } catch (nb::python_error& error) {
        error.restore();
        return Signal::leave;
    }
    return Signal::go_on;
}

void translate(const std::exception_ptr& thrown, void*) {
    try {
        std::rethrow_exception(thrown);
    } catch (const Refused& refused) {
        const nb::object error = nb::module_::import_("planner.base.errors").attr("ArrayError");
        PyErr_SetString(error.ptr(), ("the compiled code cannot use what it was given: " + refused.why + ".").c_str());
    } catch (const Interrupted&) {  // the exception is set already
    }
}

}  // namespace

NB_MODULE(compiled, m) {
    nb::set_leak_warnings(false);  // caches keep what they have until the process ends
    nb::register_exception_translator(translate);
    main_thread = nb::cast<uint64_t>(nb::module_::import_("threading").attr("main_thread")().attr("ident"));
    ask = asked;
    m.def("threads", &threads, "How many threads work is shared among; the results are the same for any number.");
    m.def(
        "set_threads", [](int most) { most_threads = most; }, "most"_a,
        "Share work among so many threads from now on; 0: as many as there are processors.");
    bind_robot(m), bind_world(m), bind_motion(m), bind_gate(m), bind_refinement(m), bind_dynamics(m), bind_graph(m);
}
