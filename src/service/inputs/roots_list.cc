// Lists the entries from which inputs can be chosen.
#include <algorithm>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "src/base/ledger.h"
#include "src/input/cloud/inputs.h"
#include "src/input/format.h"
#include "src/service/inputs/roots.h"

namespace tessera::service {
namespace {

constexpr std::string_view uploads = "upload:";

Error no_folder(const std::string& folder) {
  return error(Errc::usage, "folder: '" + folder + "' is not a folder below those that are configured for inputs");
}

// "a/b" for "./a//b/", "." for "".
std::string tidy(const std::string& folder) {
  std::string path = std::filesystem::path(folder).lexically_normal().string();
  while (path.size() > 1 && path.ends_with('/')) path.pop_back();
  return path.empty() ? "." : path;
}

}  // namespace

// `begin` is the prefix of names in the folder.
Status Roots::add_entries(const Root& root, const std::string& folder, const std::string& begin,
                          std::vector<RootEntry>& entries) {
  BOOST_OUTCOME_TRY(names, names_in(root.folder, folder));
  for (const auto& name : names) {
    if (const auto* ledger = Ledger::of_thread()) {
      BOOST_OUTCOME_TRYV(ledger->go_on());
    }
    const auto found = look_for(root.folder, below(folder, name));
    // Links that lead out are left out, and so are entries that vanished or cannot be read.
    if (!found || !found.value()) continue;
    const FoundBeneath& one = *found.value();
    if (one.kind == KindBeneath::other || (one.kind == KindBeneath::file && !has_point_file_name(name))) continue;
    if (one.kind == KindBeneath::folder) {
      const auto result = is_result_folder(one.real);
      if (!result || result.value()) continue;
    }
    entries.push_back({begin + name, one});
  }
  return success();
}

Result<std::vector<RootEntry>> Roots::list(const std::string& folder) const {
  if (folder.find('\0') != std::string::npos) return error(Errc::usage, "folder: holds a zero byte");
  const bool uploaded = folder.starts_with(uploads);
  const std::string inside = tidy(uploaded ? folder.substr(uploads.size()) : folder);
  if (goes_up(inside)) return error(Errc::usage, "folder: '" + folder + "' must not contain '..'");
  std::vector<RootEntry> entries;
  std::set<std::string> names;
  bool any = false;
  for (const Root& root : uploaded ? uploads_ : roots_) {
    std::optional<std::string> path = inside;
    if (inside.front() == '/') {
      path = uploaded ? std::nullopt : from_folder(inside, root.given);
      if (!path && !uploaded) path = from_folder(inside, root.real);
      if (!path) continue;
    }
    const auto found = look_for(root.folder, *path);
    if (!found || !found.value() || found.value()->kind != KindBeneath::folder) continue;
    any = true;
    std::vector<RootEntry> here;
    std::string begin = inside == "." ? "" : inside + "/";
    if (uploaded) begin = std::string(uploads) + begin;
    BOOST_OUTCOME_TRYV(add_entries(root, *path, begin, here));
    for (auto& entry : here) {
      // If several roots have files of the same name, the first is meant. Folders of the same name count as one.
      const bool there = !names.insert(entry.name).second;
      if (there && entry.found.kind == KindBeneath::folder) continue;
      if (there) entry.name = (root.given / below(*path, entry.name.substr(begin.size()))).lexically_normal().string();
      entries.push_back(std::move(entry));
    }
  }
  if (inside == "." && !uploaded && !uploads_.empty()) {
    BOOST_OUTCOME_TRYV(add_entries(uploads_.front(), ".", std::string(uploads), entries));
    any = true;
  }
  if (!any && inside != ".") return no_folder(folder);
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return entries;
}

}  // namespace tessera::service
