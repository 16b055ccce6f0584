// What each version of a result was made of, for people.
//
// The log is a file beside the manifests of older versions. A writer replaces the file before the manifest, so the log
// may have a version more than the result: readers leave out entries of higher versions than the manifest's. Programs
// that do not know the log change results without it; then it has no entries of their versions.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/result/store/digest.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct VersionEntry {
  std::uint32_t version = 1;
  std::int64_t seconds = 0;          // since 1970, when it was written
  std::uint64_t added = 0;           // points, duplicates included
  std::uint64_t removed = 0;         // likewise
  std::vector<std::string> inputs;   // the files of the added points, the first few
  std::uint64_t input_files = 0;     // how many files there were
  std::vector<std::string> columns;  // that came with the version
  std::uint64_t vertices = 0, cells = 0, tiles = 0;
  std::uint64_t tiles_written = 0, bytes_written = 0;
  std::optional<Digest> digest;
  std::vector<std::string> command;  // shortened, if it is long
  std::string software_version;
  friend bool operator==(const VersionEntry&, const VersionEntry&) = default;
};

struct VersionLog {
  std::uint32_t keep = 1;              // how many of the newest versions stay readable
  std::vector<VersionEntry> versions;  // ascending; the newest thousand
};

// What the manifest says of its version, with its files as written for it. `seconds`: when that was.
VersionEntry entry_of(const Manifest& manifest, std::int64_t seconds);
// Puts the entry at the end. Leaves out the oldest entries when there are many, and shortens what is long.
void append(VersionLog& log, VersionEntry entry);

// Reads the log of a result at this version. Without a log: one that says nothing. Errors: corrupt, io.
Result<VersionLog> read_version_log(const std::filesystem::path& out, std::uint32_t version);
std::string version_log_text(const VersionLog& log);

// The versions of a result, and which of them can be read. Of versions without an entry that can be read, the entry is
// made of the manifest.
struct ToldVersion {
  VersionEntry entry;
  bool readable = false;
};
struct ToldVersions {
  std::uint32_t newest = 1;
  std::uint32_t keep = 1;
  std::vector<ToldVersion> versions;  // ascending
};
// Errors: those of read_manifest() and read_version_log().
Result<ToldVersions> tell_versions(const std::filesystem::path& out);

}  // namespace tessera
