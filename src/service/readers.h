// Results that are open for questions: a few, those asked last, within a budget of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "src/result/query/stored_triangulation.h"
#include "src/service/results.h"

namespace tessera {

// Its folder stays the one that was opened, whatever is put in its place.
struct Reader {
  std::string name;
  Results::Held held;
  query::StoredTriangulation stored;
  std::stop_source gone;  // stopped when the result is removed
  struct Hull {
    std::mutex mutex;
    std::optional<std::vector<Point>> points;
  };
  std::unique_ptr<Hull> hull = std::make_unique<Hull>();  // once it was asked for
};

class Readers {
 public:
  // Each reader has its part of `memory_bytes` for tiles; what questions hold at once comes on top.
  Readers(Results& results, std::uint64_t memory_bytes) : results_(results), memory_bytes_(memory_bytes) {}

  // The result that has this name now. Errors: those of Results::hold() and StoredTriangulation::open().
  Result<std::shared_ptr<Reader>> open(std::string_view name);
  // Whoever still asks it is stopped, and its memory is given back then.
  void close(std::string_view name);
  std::size_t count() const;

 private:
  static constexpr std::size_t readers_max = 4;

  Results& results_;
  const std::uint64_t memory_bytes_;
  mutable std::mutex mutex_;
  std::list<std::shared_ptr<Reader>> readers_;  // the last asked first
};

}  // namespace tessera
