#include "src/input/snapshot/snapshot_set.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "src/input/format.h"

namespace tessera::snapshot {
namespace {

// The name of a file of a snapshot, and which file it is: "snap_064.3" is file 3 of "snap_064".
struct FileName {
  std::string snapshot;
  std::string number, ending;
};

FileName split(const std::filesystem::path& file) {
  const auto path = without_packing(file);
  const bool has_ending = path.extension() == ".hdf5" || path.extension() == ".h5";
  const std::string text = has_ending ? (path.parent_path() / path.stem()).string() : path.string();
  const std::string name = std::filesystem::path(text).filename().string();
  const std::size_t dot = name.rfind('.');
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  if (dot == std::string::npos || dot + 1 == name.size() ||
      !std::all_of(name.begin() + static_cast<std::ptrdiff_t>(dot) + 1, name.end(), is_digit))
    return {path.string(), "", ""};
  return {text.substr(0, text.size() - (name.size() - dot)), name.substr(dot + 1),
          has_ending ? path.extension().string() : ""};
}

Status check_snapshot(const std::string& name, const std::vector<const FileInfo*>& files) {
  const SnapshotPart& first = *files.front()->snapshot;
  const auto bad = [](const FileInfo& file, const std::string& what) {
    return error(Errc::bad_input, file.path.string() + ": " + what);
  };
  std::set<std::string> there;
  std::uint64_t points = 0;
  for (const FileInfo* file : files) {
    const SnapshotPart& part = *file->snapshot;
    if (part.run != first.run || part.files != first.files)
      return bad(*file, "is of another snapshot than " + files.front()->path.string() +
                            ": their headers differ in the time, the box, the masses or the numbers of particles");
    if (!there.insert(split(file->path).number).second) return bad(*file, "is given twice");
    points += *file->points + file->points_passed_over;
  }
  if (files.size() != first.files) {
    std::string missing;
    for (std::uint64_t i = 0; i < first.files && missing.empty(); ++i)
      if (!there.contains(std::to_string(i)))
        missing = name + "." + std::to_string(i) + split(files.front()->path).ending;
    return bad(*files.front(), "is one of " + std::to_string(first.files) + " files of a snapshot, but " +
                                   std::to_string(files.size()) + (files.size() == 1 ? " is" : " are") + " given" +
                                   (missing.empty() ? "" : "; " + missing + " is missing"));
  }
  if (points != first.points)
    return bad(*files.front(), "says that its snapshot has " + std::to_string(first.points) +
                                   " particles, but its files have " + std::to_string(points));
  return success();
}

}  // namespace

Status check_snapshots(std::span<const FileInfo> files) {
  std::map<std::string, std::vector<const FileInfo*>> snapshots;
  for (const FileInfo& file : files)
    if (file.snapshot && file.snapshot->files > 1) snapshots[split(file.path).snapshot].push_back(&file);
  for (const auto& [name, parts] : snapshots) {
    BOOST_OUTCOME_TRYV(check_snapshot(name, parts));
  }
  return success();
}

}  // namespace tessera::snapshot
