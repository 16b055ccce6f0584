#include "src/service/client/written.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/service/client/download.h"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

bool leads_elsewhere(const fs::path& inside) {
  return inside.empty() || inside.is_absolute() || inside.native().find('\0') != std::string::npos ||
         std::any_of(inside.begin(), inside.end(),
                     [](const fs::path& part) { return part.empty() || part == ".." || part == "."; });
}

bool is_name(const std::string& text) { return !leads_elsewhere(text) && !fs::path(text).has_parent_path(); }

Error no_place(const WrittenFile& file) {
  return error(Errc::corrupt, "the server says that the export has written '" + file.path +
                                  "', but an export cannot write that file; the file was not downloaded");
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

Result<std::vector<fs::path>> places_in_folder(const std::vector<WrittenFile>& files, const std::string& made,
                                               const fs::path& folder) {
  std::vector<fs::path> places;
  for (const auto& file : files) {
    if (!is_name(made) || !file.inside.starts_with(made + "/")) return no_place(file);
    const auto inside = file.inside.substr(made.size() + 1);
    if (leads_elsewhere(inside)) return no_place(file);
    places.push_back(folder / inside);
  }
  return places;
}

Result<std::vector<fs::path>> places_beside(const std::vector<WrittenFile>& files, const std::string& made,
                                            const fs::path& target, const std::set<std::string>& endings) {
  std::vector<fs::path> places;
  for (const auto& file : files) {
    const fs::path name(file.inside);
    if (!is_name(made) || !is_name(file.inside) || name.stem() != fs::path(made).stem()) return no_place(file);
    auto to = target;
    if (endings.contains(name.extension())) {
      to.replace_extension(name.extension());
    } else if (file.inside != made) {
      return no_place(file);
    }
    if (std::find(places.begin(), places.end(), to) != places.end()) return no_place(file);
    places.push_back(std::move(to));
  }
  return places;
}

Status fetch_written(Server& server, const std::string& triangulation, const std::vector<WrittenFile>& files,
                     const std::vector<fs::path>& places,
                     const std::function<void(std::uint64_t, std::uint64_t)>& on_progress,
                     const std::stop_token& stop) {
  std::uint64_t total = 0, before = 0;
  for (const auto& file : files) total += file.bytes;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto& file = files[i];
    const auto& to = places.at(i);
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

}  // namespace tessera::client
