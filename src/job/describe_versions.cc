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

// Words with something between them, without what could control a terminal.
std::string joined(const Json& words, const char* between) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : between) + word.get<std::string>();
  return printable(text);
}

std::uint64_t number(const Json& version, const char* key) { return version.at(key).get<std::uint64_t>(); }

// "+3 -1", "column area"
std::string change_of(const Json& version) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : " ") + part; };
  if (number(version, "added") > 0) add("+" + grouped(number(version, "added")));
  if (number(version, "removed") > 0) add("-" + grouped(number(version, "removed")));
  const Json& columns = version.at("columns");
  if (!columns.empty()) add((columns.size() == 1 ? "column " : "columns ") + joined(columns, ", "));
  return text.empty() ? "files only" : text;
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

VersionRow to_row(const Json& version) {
  const Json& digest = version.at("digest");
  return {std::to_string(number(version, "version")),
          printable(version.at("time").get<std::string>()),
          change_of(version),
          grouped(number(version, "vertices")),
          grouped(number(version, "cells")),
          grouped(number(version, "tiles_written")) + " of " + grouped(number(version, "tiles")),
          human_bytes(number(version, "bytes_written")),
          digest.is_null() ? "" : printable(digest.get<std::string>()),
          version.at("readable").get<bool>() ? "yes" : "no",
          joined(version.at("command"), " ")};
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

Result<std::string> describe_versions_of(const std::string& folder, const std::string& name) {
  BOOST_OUTCOME_TRY(told, tell_versions(folder));
  Json list = Json::array();
  for (const auto& version : told.versions) list.push_back(to_json(version));
  const Json object{
      {"result", name}, {"version", told.newest}, {"keep_versions", told.keep}, {"versions", std::move(list)}};
  return json_text(object) + "\n";
}

std::optional<std::string> versions_text(const Json& told) {
  std::vector<VersionRow> rows{
      {"version", "time", "change", "vertices", "cells", "tiles written", "bytes", "digest", "readable", "command"}};
  try {
    for (const auto& version : told.at("versions")) rows.push_back(to_row(version));
  } catch (const Json::exception&) {
    return std::nullopt;
  }
  return version_table(rows);
}

Result<std::string> describe_versions(const std::string& folder, bool json) {
  BOOST_OUTCOME_TRY(text, describe_versions_of(folder, folder));
  if (json) return text;
  return versions_text(parse_ordered_json(text)).value();
}

}  // namespace tessera
