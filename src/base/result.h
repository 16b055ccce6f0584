// Errors as values. What depends on input, disk or network returns a Result. Bugs of this program end it (check.h).
#pragma once

// <boost/outcome.hpp> is not included: most of its cost is for streams and for error codes of std and boost, which are
// not used here.
#include <boost/outcome/basic_result.hpp>
#include <boost/outcome/policy/terminate.hpp>
#include <boost/outcome/try.hpp>
#include <cstdint>
#include <new>
#include <string>
#include <utility>

namespace tessera {

// The kinds of errors. Each kind has an exit status of its own (docs/exit-status.md). A kind exists only where a caller
// acts on it.
enum class Errc : std::uint8_t {
  ok = 0,
  usage = 2,         // the command line or the configuration
  bad_input = 3,     // a file that is not what it claims to be, or points that do not span space
  io = 4,            // the system refused: missing or unreadable file, full disk
  corrupt = 5,       // a file of Tessera's own: wrong checksum or version, truncated
  not_delaunay = 6,  // verify found the result wrong
  memory = 7,        // the job cannot be done within its memory
  interrupted = 8,   // Ctrl-C; the run folder can be resumed
  internal = 9,      // everything else; the text says what
};

struct Error {
  Errc code = Errc::internal;
  // the sentence: file, place, what is wrong: "lyon.ply, line 812: y is nan"; has marks of options (option.h)
  std::string where;
};

template <class T>
using Result = boost::outcome_v2::basic_result<T, Error, boost::outcome_v2::policy::terminate>;
using Status = Result<void>;

inline auto success() { return boost::outcome_v2::success(); }
inline Error error(Errc code, std::string where) { return Error{code, std::move(where)}; }

// Returns the error that make() gives, or a short one that needs no memory when make() runs out of memory. For
// exception handlers, which must not throw.
template <class Make>
Error worded(Make&& make) noexcept {
  try {
    return make();
  } catch (const std::bad_alloc&) {
    return error(Errc::memory, "out of memory");
  }
}

}  // namespace tessera

// To unwrap a Result, use BOOST_OUTCOME_TRY(name, expression), which declares auto&& name, or
// BOOST_OUTCOME_TRYV(expression).
