// What is told of a change of a result: the JSON object that the command prints, and that a job of the daemon gives.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tessera {

struct Updated;       // src/delaunay/update/update.h
struct VersionEntry;  // src/result/version_log.h

struct AskedChange {
  std::string output;  // the name of the result
  bool dry_run = false;
  std::uint64_t added = 0;  // points
  // For the estimate of a dry run.
  int dimension = 3;
  std::uint64_t memory_bytes = 0;
  unsigned threads = 1;
};
nlohmann::ordered_json told_of(const Updated& updated, const AskedChange& asked);
// Of a change that was made before, as finish_earlier() or the log of versions tells. Of version 1, a new folder, it is
// unknown what came and went.
nlohmann::ordered_json told_of_made(const VersionEntry& version, const std::string& output);

}  // namespace tessera
