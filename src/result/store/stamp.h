// The stamp of a file that was made of a result: which version of the result, and the digest of its triangulation. The
// stamp does not depend on the tiles, because the digest does not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/result/store/tile_store.h"

namespace tessera {

struct ResultStamp {
  std::uint32_t version = 1;
  std::string digest = {};  // as digest_text() writes it; empty when a tile has none
  friend bool operator==(const ResultStamp&, const ResultStamp&) = default;
};

ResultStamp stamp_of(const Manifest& manifest);

// "result: version 3, digest 5d0c...", for a comment of one line.
std::string comment_of(const ResultStamp& stamp);

// The same in a text that begins with lines of comments, such as the head of a PLY file.
std::optional<ResultStamp> stamp_in_comments(std::string_view text);

// Items of metadata for files that GDAL writes: their names and values. Of a product of two results, `lower` is the one
// that is subtracted.
using MetadataItems = std::vector<std::pair<std::string, std::string>>;
MetadataItems metadata_of(const ResultStamp& stamp, const std::optional<ResultStamp>& lower = {});

// {"version":3,"digest":"5d0c..."}
std::string json_of(const ResultStamp& stamp);

}  // namespace tessera
