#include "src/result/version_log.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/result/far_files.h"
#include "src/result/held_manifest.h"

namespace tessera {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

constexpr std::size_t entries_max = 1000, inputs_max = 16, words_max = 64, word_bytes_max = 256;

void shorten(std::string& text) {
  if (text.size() > word_bytes_max) text = text.substr(0, word_bytes_max) + "...";
}

ordered_json to_json(const VersionEntry& entry) {
  ordered_json value{{"version", entry.version}, {"seconds", entry.seconds}};
  if (entry.added > 0) value["added"] = entry.added;
  if (entry.removed > 0) value["removed"] = entry.removed;
  if (!entry.inputs.empty()) value["inputs"] = entry.inputs;
  if (entry.input_files > 0) value["input_files"] = entry.input_files;
  if (!entry.columns.empty()) value["columns"] = entry.columns;
  value["vertices"] = entry.vertices;
  value["cells"] = entry.cells;
  value["tiles"] = entry.tiles;
  value["tiles_written"] = entry.tiles_written;
  value["bytes_written"] = entry.bytes_written;
  if (entry.digest) value["digest"] = digest_text(*entry.digest);
  value["command"] = entry.command;
  value["software_version"] = entry.software_version;
  return value;
}

std::uint64_t count(const json& value, const char* key) {
  return value.contains(key) ? value.at(key).get<std::uint64_t>() : 0;
}

std::vector<std::string> words(const json& value, const char* key) {
  return value.contains(key) ? value.at(key).get<std::vector<std::string>>() : std::vector<std::string>();
}

VersionEntry to_entry(const json& value) {
  VersionEntry entry{.version = value.at("version").get<std::uint32_t>(),
                     .seconds = value.at("seconds").get<std::int64_t>(),
                     .added = count(value, "added"),
                     .removed = count(value, "removed"),
                     .inputs = words(value, "inputs"),
                     .input_files = count(value, "input_files"),
                     .columns = words(value, "columns"),
                     .vertices = count(value, "vertices"),
                     .cells = count(value, "cells"),
                     .tiles = count(value, "tiles"),
                     .tiles_written = count(value, "tiles_written"),
                     .bytes_written = count(value, "bytes_written"),
                     .digest = {},
                     .command = words(value, "command"),
                     .software_version = value.at("software_version").get<std::string>()};
  if (value.contains("digest")) entry.digest = parse_digest(value.at("digest").get<std::string>());
  return entry;
}

// When the file was written.
Result<std::int64_t> written_at(const fs::path& path) {
  BOOST_OUTCOME_TRY(status, look_at(path));
  return status ? static_cast<std::int64_t>(status->st_mtim.tv_sec) : 0;
}

Result<VersionEntry> entry_of_file(const fs::path& path) {
  BOOST_OUTCOME_TRY(bytes, read_whole(path));
  BOOST_OUTCOME_TRY(manifest, parse_manifest(path, bytes));
  BOOST_OUTCOME_TRY(seconds, written_at(path));
  return entry_of(manifest, seconds);
}

}  // namespace

VersionEntry entry_of(const Manifest& manifest, std::int64_t seconds) {
  VersionEntry entry{.version = manifest.version,
                     .seconds = seconds,
                     .inputs = {},
                     .columns = {},
                     .vertices = manifest.vertices,
                     .cells = manifest.cells,
                     .tiles = manifest.tiles.size(),
                     .digest = manifest.digest,
                     .command = manifest.command,
                     .software_version = manifest.software_version};
  for (const TileEntry& tile : manifest.tiles) {
    if (tile.version != manifest.version) continue;
    ++entry.tiles_written;
    entry.bytes_written += tile.bytes;
  }
  for (const ResultColumn& column : manifest.columns) {
    if (column.version == manifest.version) entry.columns.push_back(column.name);
  }
  if (manifest.version == 1) {
    entry.added = manifest.vertices + manifest.duplicates;
    entry.input_files = manifest.inputs.size();
    for (const auto& input : std::span(manifest.inputs).first(std::min(inputs_max, manifest.inputs.size())))
      entry.inputs.push_back(input.path);
  }
  return entry;
}

void append(VersionLog& log, VersionEntry entry) {
  if (entry.inputs.size() > inputs_max) entry.inputs.resize(inputs_max);
  if (entry.command.size() > words_max) {
    entry.command.resize(words_max);
    entry.command.emplace_back("...");
  }
  for (auto* list : {&entry.inputs, &entry.command, &entry.columns}) std::ranges::for_each(*list, shorten);
  log.versions.push_back(std::move(entry));
  if (log.versions.size() > entries_max)
    log.versions.erase(log.versions.begin(), log.versions.end() - static_cast<std::ptrdiff_t>(entries_max));
}

Result<VersionLog> read_version_log(const fs::path& out, std::uint32_t version) {
  VersionLog log;
  const auto path = version_log_file(out);
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return log;
  BOOST_OUTCOME_TRY(bytes, read_whole(path));
  const auto corrupt = [&](const std::string& why) {
    return error(Errc::corrupt,
                 path.string() + ": is damaged" + why + "; the result does not need this file, which may be removed");
  };
  const json value = parse_json({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (value.is_discarded() || !value.is_object()) return corrupt("");
  try {
    log.keep = value.at("keep").get<std::uint32_t>();
    for (const auto& entry : value.at("versions")) {
      VersionEntry read = to_entry(entry);
      if (read.version > version) break;  // left by a writer that was ended
      if (!log.versions.empty() && read.version <= log.versions.back().version)
        return corrupt(": the versions do not ascend");
      log.versions.push_back(std::move(read));
    }
  } catch (const json::exception& wrong) {
    return corrupt(std::string(": ") + wrong.what());
  }
  if (log.keep == 0) return corrupt(": no version is kept");
  return log;
}

std::string version_log_text(const VersionLog& log) {
  std::string text = "{\n  \"keep\": " + std::to_string(log.keep) + ",\n  \"versions\": [";
  for (std::size_t i = 0; i < log.versions.size(); ++i)
    text += (i == 0 ? "\n    " : ",\n    ") + json_text(to_json(log.versions[i]), -1);
  return text + "\n  ]\n}\n";
}

Result<ToldVersions> tell_versions(const fs::path& out) {
  if (result::is_far(out))
    return error(Errc::usage, out.string() +
                                  ": only the newest version of a result in an object store can be read, so "
                                  "there is no list of versions");
  BOOST_OUTCOME_TRY(held, result::hold_manifest(out));
  const Manifest& manifest = held.manifest;
  BOOST_OUTCOME_TRY(log, read_version_log(out, manifest.version));
  BOOST_OUTCOME_TRY(readable, result::readable_versions(out, manifest.version));
  std::map<std::uint32_t, ToldVersion> all;
  for (auto& entry : log.versions) all[entry.version] = {std::move(entry), false};
  for (const std::uint32_t number : readable) {
    if (!all.contains(number)) {
      const auto copy = version_copy(out, number);
      BOOST_OUTCOME_TRY(is_copy, is_there(copy));
      const auto path = number == manifest.version ? manifest_file(out) : is_copy ? copy : version_file(out, number);
      BOOST_OUTCOME_TRY(entry, entry_of_file(path));
      all[number] = {std::move(entry), false};
    }
    all[number].readable = true;
  }
  ToldVersions told{.newest = manifest.version, .keep = log.keep, .versions = {}};
  for (auto& [number, version] : all) told.versions.push_back(std::move(version));
  return told;
}

}  // namespace tessera
