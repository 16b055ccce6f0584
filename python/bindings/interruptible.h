// Ctrl-C while C++ works. Python only notes the signal; its main thread has to ask, holding the GIL. In other threads
// asking does nothing.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <stop_token>

namespace tessera::python {

// Throws the KeyboardInterrupt (or what else a signal handler raised) that is due. REQUIRES: the GIL.
inline void check_signals() {
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
}

// work(stop_token) in a thread of its own, so that this one can ask for signals, without the GIL in between.
// REQUIRES: the GIL; that `work` needs none, and ends soon after a stop is requested.
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
