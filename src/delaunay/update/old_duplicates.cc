#include "src/delaunay/update/old_duplicates.h"

#include <algorithm>
#include <utility>

namespace tessera {

Result<OldDuplicates> OldDuplicates::open(const TileSource& source) {
  OldDuplicates old;
  const Manifest& manifest = source.manifest();
  if (manifest.duplicates_xxh3 == 0) return old;
  BOOST_OUTCOME_TRY(pairs, read_duplicates(source.folder(), manifest));
  BOOST_OUTCOME_TRY(rows, DuplicateRows::open(source.folder(), manifest));
  if (rows && pairs.size() != manifest.duplicates)
    return error(Errc::corrupt, source.folder().string() + ": there are " + std::to_string(pairs.size()) +
                                    " duplicates, but the manifest says " + std::to_string(manifest.duplicates));
  old.pairs_ = std::move(pairs);
  if (rows) old.rows_ = std::make_shared<const DuplicateRows>(std::move(*rows));
  return old;
}

std::optional<std::span<const std::byte>> OldDuplicates::row(PointId id) const {
  if (const auto kept = kept_.find(id); kept != kept_.end()) return std::span<const std::byte>(kept->second);
  if (!rows_) return std::nullopt;
  const auto pair = std::lower_bound(pairs_.begin(), pairs_.end(), DuplicatePair{id, PointId{0}});
  if (pair == pairs_.end() || pair->duplicate != id) return std::nullopt;
  return rows_->row(static_cast<std::size_t>(pair - pairs_.begin()));
}

}  // namespace tessera
