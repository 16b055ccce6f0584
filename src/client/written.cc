#include "src/client/written.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "src/client/download.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

bool leads_elsewhere(const fs::path& inside) {
  return inside.empty() || inside.is_absolute() ||
         std::any_of(inside.begin(), inside.end(), [](const fs::path& part) { return part == ".." || part == "."; });
}

}  // namespace

Result<std::vector<WrittenFile>> written_files(const nlohmann::ordered_json& outcome) {
  const auto wrong = [] { return error(Errc::corrupt, "the server does not say which files the export has written"); };
  const auto list = outcome.find("written");
  if (list == outcome.end() || !list->is_array()) return wrong();
  const std::string begin = exports_folder("").string() + "/";
  std::vector<WrittenFile> files;
  for (const auto& entry : *list) {
    const auto is = [&](const char* key, auto type) { return entry.contains(key) && (entry[key].*type)(); };
    using Json = nlohmann::ordered_json;
    if (!entry.is_object() || !is("path", &Json::is_string) || !is("bytes", &Json::is_number_unsigned) ||
        !is("xxh3", &Json::is_string))
      return wrong();
    WrittenFile file;
    file.path = entry["path"].get<std::string>();
    file.bytes = entry["bytes"].get<std::uint64_t>();
    const auto sum = entry["xxh3"].get<std::string>();
    const auto [end, failed] = std::from_chars(sum.data(), sum.data() + sum.size(), file.xxh3, 16);
    if (failed != std::errc{} || end != sum.data() + sum.size() || !file.path.starts_with(begin)) return wrong();
    file.inside = file.path.substr(begin.size());
    if (leads_elsewhere(file.inside)) return wrong();
    files.push_back(std::move(file));
  }
  return files;
}

Status fetch_written(Server& server, const std::string& triangulation, const std::vector<WrittenFile>& files,
                     const std::function<fs::path(const WrittenFile&)>& place,
                     const std::function<void(std::uint64_t, std::uint64_t)>& on_progress,
                     const std::stop_token& stop) {
  std::uint64_t total = 0, before = 0;
  for (const auto& file : files) total += file.bytes;
  for (const auto& file : files) {
    const auto to = place(file);
    if (to.has_parent_path()) {
      BOOST_OUTCOME_TRYV(make_directories(to.parent_path()));
    }
    std::uint64_t come = 0;
    const RemoteFile remote{.triangulation = triangulation,
                            .path = file.path,
                            .bytes = file.bytes,
                            .xxh3 = file.xxh3,
                            .in_manifest = false};
    BOOST_OUTCOME_TRYV(download(
        server, remote, to,
        [&](std::uint64_t bytes) {
          come += bytes;
          on_progress(std::min(before + come, total), total);
        },
        stop));
    BOOST_OUTCOME_TRYV(sync_folder(to.has_parent_path() ? to.parent_path() : "."));
    before += file.bytes;
  }
  return success();
}

}  // namespace tessera
