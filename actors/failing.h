// How an actor that ends says so.
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

// What an exception means for the job. `who()`: "tile 7", ... Needs no memory when there is none.
template <class Who>
Failure failure_of(const std::exception_ptr& exception, Who who) noexcept {
  try {
    std::rethrow_exception(exception);
  } catch (const TileTooLarge& e) {
    return failure_of(worded([&] { return error(Errc::memory, who() + " " + e.what() + ": use smaller tiles"); }));
  } catch (const Stopped&) {
    return failure_of(worded([&] { return error(Errc::interrupted, who() + " was stopped at its work"); }));
  } catch (const std::bad_alloc&) {
    return failure_of(worded([&] {
      return error(Errc::memory,
                   "out of memory while working on " + who() + ": use smaller tiles or a smaller " + option("memory"));
    }));
  } catch (const std::exception& e) {
    return failure_of(worded([&] { return error(Errc::internal, who() + ": " + e.what()); }));
  } catch (...) {
    return failure_of(worded([&] { return error(Errc::internal, who() + ": an exception of unknown kind"); }));
  }
}

// Of an actor that has said nothing else. Needs no memory.
inline Failure ended_unexpectedly() noexcept { return failure_of(error(Errc::internal, "unexpected end")); }

// A reason of CAF's, for people: none of its own words.
std::string in_words(const caf::error& reason);

// Why an actor that was watched is gone without having said so.
Failure lost(const std::string& who, const caf::error& reason);

}  // namespace tessera
