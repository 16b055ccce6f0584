#include "src/result/heights/copies.h"

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/input/cloud/cloud.h"

namespace tessera {

namespace fs = std::filesystem;

Result<LasPacking> parse_las_packing(const std::string& text) {
  if (text == "las") return LasPacking::las;
  if (text == "laz") return LasPacking::laz;
  return error(Errc::usage, "'" + text + "' is not a format of the copies; the formats are las and laz");
}

Result<std::vector<HeightsFile>> plan_copies(const std::vector<std::string>& inputs, const fs::path& folder,
                                             const HeightsOptions& options, bool overwrite) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open(inputs, {.dimension = 3, .threads = options.threads}, options.stop));
  std::vector<HeightsFile> files;
  std::map<std::string, fs::path> taken;
  for (const FileInfo& file : cloud.files()) {
    if (file.format != "las" && file.format != "laz")
      return error(Errc::bad_input, file.path.string() + ": is not LAS or LAZ (it is " + file.format +
                                        "); heights are written into copies of LAS and LAZ files");
    if (!file.packing.empty())
      return error(Errc::bad_input, file.path.string() + ": is compressed (" + file.packing +
                                        "); heights are written into copies of LAS and LAZ files, so unpack it first");
    fs::path name = file.path.filename();
    if (options.packing == LasPacking::las) name.replace_extension(".las");
    if (options.packing == LasPacking::laz) name.replace_extension(".laz");
    const auto [other, fresh] = taken.try_emplace(name.string(), file.path);
    if (!fresh)
      return error(Errc::usage, file.path.string() + ": has the same name as " + other->second.string() +
                                    "; write them into different folders, one call each");
    const fs::path to = folder / name;
    BOOST_OUTCOME_TRY(there, is_there(to));
    if (there && !overwrite)
      return error(Errc::usage, to.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
    files.push_back({.from = file.path, .to = to, .bytes = file.bytes});
  }
  return files;
}

Status write_copies(const query::StoredTriangulation& ground, std::vector<HeightsFile>& files,
                    const HeightsOptions& options, const std::function<void(double)>& progress) {
  std::uint64_t bytes = 0, done = 0;
  for (const auto& file : files) bytes += file.bytes;
  for (auto& file : files) {
    BOOST_OUTCOME_TRY(copy, copy_with_heights(ground, file.from, file.to, options));
    file.copy = copy;
    done += file.bytes;
    if (progress && bytes > 0) progress(static_cast<double>(done) / static_cast<double>(bytes));
  }
  return success();
}

HeightsCopy all_copies(const std::vector<HeightsFile>& files) {
  HeightsCopy all;
  for (const auto& file : files) {
    all.points += file.copy.points;
    all.outside += file.copy.outside;
  }
  return all;
}

std::string to_json(const std::vector<HeightsFile>& files) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& file : files)
    list.push_back({{"input", file.from.string()},
                    {"output", file.to.string()},
                    {"points", file.copy.points},
                    {"outside", file.copy.outside}});
  const HeightsCopy all = all_copies(files);
  const nlohmann::ordered_json object{
      {"event", "heights"}, {"files", std::move(list)}, {"points", all.points}, {"outside", all.outside}};
  return json_text(object);
}

}  // namespace tessera
