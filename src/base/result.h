// Errors as values: input, disk and network give a Result; our own mistakes are asserted.
#pragma once

// Not <boost/outcome.hpp>: streams and the std and boost error codes, which nothing here uses, are most of its cost.
#include <boost/outcome/basic_result.hpp>
#include <boost/outcome/policy/terminate.hpp>
#include <boost/outcome/try.hpp>
#include <cstdint>
#include <new>
#include <string>
#include <utility>

namespace tessera {

// A code exists only where a caller acts on it: each is a group with its own exit status (docs/exit-status.md).
enum class Errc : std::uint8_t {
  ok = 0,
  usage = 2,         // the command line or the configuration
  bad_input = 3,     // a file that cannot be read as what it claims to be, or points that span no volume
  io = 4,            // the system refused: missing, unreadable, full disk
  corrupt = 5,       // our own files: checksum, version, truncation
  not_delaunay = 6,  // verify found the result wrong
  memory = 7,        // the job cannot be done within its memory
  interrupted = 8,   // Ctrl-C; the run folder can be resumed
  internal = 9,      // everything else, told apart by its text
};

struct Error {
  Errc code = Errc::internal;
  std::string where;  // "lyon.ply, line 812: y is nan": file, place, what is wrong; options as marks (base/option.h)
};

template <class T>
using Result = boost::outcome_v2::basic_result<T, Error, boost::outcome_v2::policy::terminate>;
using Status = Result<void>;

inline auto success() { return boost::outcome_v2::success(); }
inline Error error(Errc code, std::string where) { return Error{code, std::move(where)}; }

// The error that `make()` gives, or a short one that needs no memory when there is none for its sentence. For handlers
// of exceptions that must not throw themselves.
template <class Make>
Error worded(Make&& make) noexcept {
  try {
    return make();
  } catch (const std::bad_alloc&) {
    return error(Errc::memory, "out of memory");
  }
}

}  // namespace tessera

// Unwrap with BOOST_OUTCOME_TRY(name, expression) (declares auto&& name) and BOOST_OUTCOME_TRYV(expression).
