#include "src/job/describe_versions.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/job/report/human.h"
#include "src/result/store/digest.h"
#include "src/result/version_log.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;
using VersionRow = std::array<std::string, 10>;

std::string time_text(std::int64_t seconds) {
  const std::time_t time = seconds;
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  std::array<char, 64> buffer{};
  return {buffer.data(), std::strftime(buffer.data(), buffer.size(), "%Y-%m-%dT%H:%M:%SZ", &parts)};
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

// "+3 -1 new.laz", "column area"
std::string change_of(const VersionEntry& entry) {
  std::vector<std::string> parts;
  if (entry.added > 0) parts.push_back("+" + grouped(entry.added));
  if (entry.removed > 0) parts.push_back("-" + grouped(entry.removed));
  if (!entry.columns.empty())
    parts.push_back((entry.columns.size() == 1 ? "column " : "columns ") + joined(entry.columns, ", "));
  if (parts.empty()) parts.emplace_back("files only");
  return printable(joined(parts, " "));
}

Json to_json(const ToldVersion& version) {
  const VersionEntry& entry = version.entry;
  return {{"version", entry.version},
          {"time", time_text(entry.seconds)},
          {"readable", version.readable},
          {"added", entry.added},
          {"removed", entry.removed},
          {"inputs", entry.inputs},
          {"input_files", entry.input_files},
          {"columns", entry.columns},
          {"vertices", entry.vertices},
          {"cells", entry.cells},
          {"tiles", entry.tiles},
          {"tiles_written", entry.tiles_written},
          {"bytes_written", entry.bytes_written},
          {"digest", entry.digest ? Json(digest_text(*entry.digest)) : Json()},
          {"command", entry.command},
          {"software_version", entry.software_version}};
}

VersionRow to_row(const ToldVersion& version) {
  const VersionEntry& entry = version.entry;
  return {std::to_string(entry.version),
          time_text(entry.seconds),
          change_of(entry),
          grouped(entry.vertices),
          grouped(entry.cells),
          grouped(entry.tiles_written) + " of " + grouped(entry.tiles),
          human_bytes(entry.bytes_written),
          entry.digest ? digest_text(*entry.digest) : "",
          version.readable ? "yes" : "no",
          printable(joined(entry.command, " "))};
}

std::string version_table(const std::vector<VersionRow>& rows) {
  std::array<std::size_t, std::tuple_size_v<VersionRow>> widths{};
  for (const VersionRow& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const VersionRow& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += (i == 0 ? "" : "  ") + row[i];
      if (i + 1 < row.size()) line.resize(line.size() + widths[i] - row[i].size(), ' ');
    }
    line.resize(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace

Result<std::string> describe_versions(const std::string& folder, bool json) {
  BOOST_OUTCOME_TRY(told, tell_versions(folder));
  if (json) {
    Json list = Json::array();
    for (const auto& version : told.versions) list.push_back(to_json(version));
    const Json object{
        {"result", folder}, {"version", told.newest}, {"keep_versions", told.keep}, {"versions", std::move(list)}};
    return json_text(object) + "\n";
  }
  std::vector<VersionRow> rows{
      {"version", "time", "change", "vertices", "cells", "tiles written", "bytes", "digest", "readable", "command"}};
  for (const auto& version : told.versions) rows.push_back(to_row(version));
  return version_table(rows);
}

}  // namespace tessera
