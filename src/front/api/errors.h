// Turns errors that are values, and the exceptions of other libraries, into Failure, the one exception of the public
// library.
#pragma once

#include <string>
#include <utility>

#include "src/base/result.h"
#include "src/front/api/entry.h"
#include "tessera/failure.h"

namespace tessera {

// Throws the error as a Failure.
[[noreturn]] void throw_failure(const Error& error);
// Throws the exception that is being handled, as a Failure.
[[noreturn]] void rethrow_as_failure();

template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw_failure(result.error());
  return std::move(result).value();
}
inline void or_throw(const Status& status) {
  if (!status) throw_failure(status.error());
}

// Runs `work` with an Entry, and returns its result. Any exception comes out as a Failure.
template <class Work>
auto guarded(Work&& work) {
  try {
    const Entry entry;
    return work();
  } catch (...) {
    rethrow_as_failure();
  }
}

}  // namespace tessera
