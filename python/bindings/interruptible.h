// Lets Ctrl-C stop C++ code. Python only notes the signal; its main thread must ask for it while it holds the GIL. In
// other threads asking does nothing.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <stop_token>

namespace tessera::python {

// Throws the exception that a signal handler has raised, mostly KeyboardInterrupt, if there is one. REQUIRES: the
// caller holds the GIL.
inline void check_signals() {
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
}

// Returns work(stop_token), which runs in a thread of its own while this thread asks for signals. A signal requests a
// stop, and its exception is thrown when `work` has ended. The GIL is released between questions. REQUIRES: the caller
// holds the GIL; `work` does not need it, and ends soon after a stop is requested.
template <class Work>
auto run_interruptible(const Work& work) {
  constexpr std::chrono::milliseconds pause{50};
  std::stop_source source;
  auto result = std::async(std::launch::async, [&] { return work(source.get_token()); });
  const auto is_done = [&] {
    const pybind11::gil_scoped_release release;
    return result.wait_for(pause) == std::future_status::ready;
  };
  while (!is_done()) {
    if (PyErr_CheckSignals() != 0) {
      pybind11::error_already_set signal;
      source.request_stop();
      const pybind11::gil_scoped_release release;
      result.wait();
      throw signal;
    }
  }
  return result.get();
}

}  // namespace tessera::python
