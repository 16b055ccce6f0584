// Keeps a few results open for questions, those used last, within a memory budget.
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
#include "src/service/results/result_folders.h"

namespace tessera::service {

// An open version of a result. It stays the same, even when another result gets its name.
struct Reader {
  std::string name;
  std::uint32_t version = 0;  // that was asked for; 0: the newest one, which it was when it was opened
  ResultFolders::Held held;
  query::StoredTriangulation stored;
  std::stop_source gone;  // stopped when the result is removed
  struct Hull {
    std::mutex mutex;
    std::optional<std::vector<Point>> points;
  };
  std::unique_ptr<Hull> hull = std::make_unique<Hull>();  // set when first asked for
};

class Readers {
 public:
  // Each reader gets its part of `memory_bytes` for tiles; what running questions hold comes on top.
  Readers(ResultFolders& results, std::uint64_t memory_bytes) : results_(results), memory_bytes_(memory_bytes) {}

  // Opens the result that has this name now, at its newest version, or at version `version`. Errors: those of
  // ResultFolders::hold() and StoredTriangulation::open(); io when the result is changed again and again.
  Result<std::shared_ptr<Reader>> open(std::string_view name, std::uint32_t version = 0);
  // Stops the questions that still use the result; then its memory is freed.
  void close(std::string_view name);
  // Call this when the result has got a new version. Questions to the old version go on, and then its files may go.
  void renew(std::string_view name);
  std::size_t count() const;

 private:
  Result<std::shared_ptr<Reader>> make(std::string_view name, std::uint32_t version, ResultFolders::Held held);
  // Null when there is none.
  std::shared_ptr<Reader> known(const std::string& identity);
  void add(const std::shared_ptr<Reader>& made);

  static constexpr std::size_t readers_max = 4;

  ResultFolders& results_;
  const std::uint64_t memory_bytes_;
  mutable std::mutex mutex_;
  std::list<std::shared_ptr<Reader>> readers_;  // the most recently used first
};

}  // namespace tessera::service
