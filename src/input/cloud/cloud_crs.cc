#include "src/input/cloud/cloud_crs.h"

#include <map>

#include "src/base/crs/crs.h"
#include "src/base/option.h"

namespace tessera {
namespace {

Error different(const FileInfo& a, const FileInfo& b) {
  return error(Errc::bad_input, a.path.string() + " and " + b.path.string() + ": have different coordinate systems, " +
                                    crs_title(a.crs) + " and " + crs_title(b.crs) +
                                    "; convert one of them, or say with " + option("crs") + " what all are in");
}

std::string some_of(std::size_t some, std::size_t all) {
  return std::to_string(some) + " of " + std::to_string(all) + " files";
}

}  // namespace

Result<CloudCrs> settle_crs(const std::vector<FileInfo>& files, const std::string& given) {
  CloudCrs settled{given, {}};
  if (!given.empty()) return settled;
  std::map<std::string, const FileInfo*> first_with;  // the files of a survey have equal texts, word for word
  const FileInfo *first = nullptr, *without = nullptr;
  std::size_t count_without = 0;
  for (const FileInfo& file : files) {
    if (!file.crs_note.empty()) settled.warnings.push_back(file.path.string() + ": " + file.crs_note);
    if (file.crs.empty()) {
      if (count_without++ == 0) without = &file;
      continue;
    }
    first_with.emplace(file.crs, &file);
    if (first == nullptr) first = &file;
  }
  if (first == nullptr) return settled;
  // A single text need not be understood: the library for that takes memory.
  const FileInfo* with_heights = nullptr;
  if (first_with.size() > 1) {
    for (const auto& [crs, file] : first_with) {
      if (!same_crs(first->crs, crs)) return different(*first, *file);
      if (with_heights != nullptr && !same_crs(with_heights->crs, crs)) return different(*with_heights, *file);
      if (with_heights == nullptr && has_heights(crs)) with_heights = file;
    }
  }
  const FileInfo& chosen = with_heights != nullptr ? *with_heights : *first;
  settled.crs = chosen.crs;
  if (without != nullptr) {
    settled.warnings.push_back(some_of(count_without, files.size()) + ", " + without->path.string() +
                               " the first, say nothing of their coordinate system; they are taken to be in that of " +
                               chosen.path.string() + ", " + crs_title(chosen.crs));
  }
  if (first_with.size() == 1 || with_heights == nullptr) return settled;
  for (const auto& [crs, file] : first_with) {
    if (has_heights(crs)) continue;
    settled.warnings.push_back(file->path.string() +
                               ": says nothing of what its heights mean; they are taken to be as in " +
                               chosen.path.string() + ", " + crs_title(chosen.crs));
    break;
  }
  return settled;
}

}  // namespace tessera
