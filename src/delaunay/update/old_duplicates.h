// The duplicates of a result that is changed, with their attributes.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/tile_source.h"

namespace tessera {

class OldDuplicates {
 public:
  OldDuplicates() = default;
  // Errors: those of read_duplicates() and DuplicateRows::open().
  static Result<OldDuplicates> open(const TileSource& source);

  const std::vector<DuplicatePair>& pairs() const { return pairs_; }  // ascending
  // Whether row_of() is known, because the result has attributes and keeps those of duplicates.
  bool has_rows() const { return rows_ != nullptr; }
  // REQUIRES: has_rows().
  std::span<const std::byte> row_of(std::size_t pair) const { return rows_->row(pair); }

  // Keeps the attributes of a vertex that becomes a duplicate.
  void keep(PointId vertex, std::span<const std::byte> row) { kept_[vertex].assign(row.begin(), row.end()); }
  // The attributes of a duplicate of the result, or of a vertex that becomes one. Nothing when they are not known.
  std::optional<std::span<const std::byte>> row(PointId id) const;

 private:
  std::vector<DuplicatePair> pairs_;
  std::shared_ptr<const DuplicateRows> rows_;
  std::map<PointId, std::vector<std::byte>> kept_;
};

}  // namespace tessera
