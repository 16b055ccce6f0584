// Bytes on another machine. A read may wait for the network, so readers say beforehand what they will read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// The bytes begin..end of a source.
struct ByteRange {
  std::uint64_t begin = 0, end = 0;
};

// What a reader has learnt of a source by reading it, for the next reader.
class Learnt {
 public:
  virtual ~Learnt() = default;
};

class FarSource : public ByteSource {
 public:
  // Fetches what is not yet here of these ranges, many at once, so that reading them does not wait. More than
  // near_bytes_max() in all calls push out what came first. Errors: those of read(). REQUIRES: all ranges are within
  // size().
  virtual Status bring(std::span<const ByteRange> ranges) const = 0;
  // How many bytes are worth bringing at a time.
  virtual std::uint64_t near_bytes_max() const = 0;
  // Opens another object as this one was opened: with the same rights, and the same way to stop. The first request is
  // for `first_bytes`. Errors: those of Objects::open().
  virtual Result<std::shared_ptr<const ByteSource>> open_beside(const std::string& name,
                                                                std::size_t first_bytes) const = 0;
  // What learn() was given last, as long as the source lives; null before. For formats whose description takes many
  // requests.
  virtual std::shared_ptr<const Learnt> learnt() const = 0;
  virtual void learn(std::shared_ptr<const Learnt> what) const = 0;
};

// FarSource::bring() for a source that is far. Does nothing for other sources.
Status bring_near(const ByteSource& source, std::span<const ByteRange> ranges);
// FarSource::near_bytes_max() for a source that is far; 0 for other sources.
std::uint64_t near_bytes_max(const ByteSource& source);

}  // namespace tessera
