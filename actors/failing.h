// Turns the end of an actor, and its reason, into a failure of the job.
#pragma once

#include <exception>
#include <new>
#include <string>

#include "actors/protocol.h"
#include "src/base/option.h"
#include "src/base/result.h"
#include "src/base/stopped.h"
#include "src/base/too_large.h"

namespace tessera {

// Returns what an exception means for the job. `who()` names the worker, as in "tile 7". When no memory is
// left for the text, returns the failure "out of memory".
template <class Who>
Failure failure_of(const std::exception_ptr& exception, Who who) noexcept {
  try {
    std::rethrow_exception(exception);
  } catch (const TileTooLarge& e) {
    return failure_of(worded([&] { return error(Errc::memory, who() + " " + e.what() + ": use smaller tiles"); }));
  } catch (const Stopped&) {
    return failure_of(worded([&] { return error(Errc::interrupted, who() + " was stopped while it worked"); }));
  } catch (const std::bad_alloc&) {
    return failure_of(worded([&] {
      return error(Errc::memory,
                   "out of memory while working on " + who() + ": use smaller tiles or a smaller " + option("memory"));
    }));
  } catch (const std::exception& e) {
    return failure_of(worded([&] { return error(Errc::internal, who() + ": " + e.what()); }));
  } catch (...) {
    return failure_of(worded([&] { return error(Errc::internal, who() + ": an unknown kind of exception"); }));
  }
}

// The failure of an actor that ends and has said nothing else. Needs no memory.
inline Failure ended_unexpectedly() noexcept { return failure_of(error(Errc::internal, "unexpected end")); }

// Returns a reason that CAF gives as words for users. CAF's own words are not in it.
std::string in_words(const caf::error& reason);

// The failure of the job when a watched actor has ended without a last message.
Failure lost(const std::string& who, const caf::error& reason);

}  // namespace tessera
