// Ranges of a named object: what every kind of object store gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/far_source.h"

namespace tessera::remote {

// One version of an object. Thread-safe.
class RangeReader {
 public:
  virtual ~RangeReader() = default;
  virtual const std::string& name() const = 0;   // for people, without secrets
  virtual std::uint64_t size() const = 0;        // in bytes
  virtual std::int64_t modified_ns() const = 0;  // nanoseconds since 1970; 0 if the server does not say
  // The bytes of each range, many ranges at once. Errors: bad_input if the object has changed since it was opened; io
  // if the server does not answer or refuses, after several tries; interrupted. REQUIRES: the ranges are within size(),
  // none is empty.
  virtual Result<std::vector<std::vector<std::byte>>> read(std::span<const ByteRange> ranges) const = 0;
  // Error bad_input if the object has changed since it was opened. For kinds whose read() cannot tell.
  virtual Status check_unchanged() const { return success(); }
};

}  // namespace tessera::remote
