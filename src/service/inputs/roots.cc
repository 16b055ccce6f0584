#include "src/service/inputs/roots.h"

#include <fcntl.h>
#include <fnmatch.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "src/base/ledger.h"
#include "src/base/option.h"
#include "src/input/bytes/objects.h"
#include "src/input/cloud/inputs.h"
#include "src/input/format.h"
#include "src/service/beneath.h"
#include "src/service/inputs/look_beneath.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t files_max = 1'000'000;
constexpr std::string_view upload_begin = "upload:";

bool has_pattern(std::string_view text) { return text.find_first_of("*?[") != std::string_view::npos; }

Result<FoundBeneath> look_at(const FileHandle& root, const std::string& path) {
  BOOST_OUTCOME_TRY(found, look_for(root, path));
  if (!found) return io_error(path, "cannot be opened", ENOENT);
  return *std::move(found);
}

// The files that a pattern means below a root, in no order; none is no error. REQUIRES: the pattern has no "..", so
// that it means each file at most once.
Result<std::vector<std::string>> expand(const FileHandle& root, const std::string& pattern) {
  std::vector<std::string> found{"."};
  for (const auto& part : fs::path(pattern)) {
    const std::string name = part.string();
    if (name.empty() || name == ".") continue;
    std::vector<std::string> next;
    for (const auto& folder : found) {
      if (!has_pattern(name)) {
        next.push_back(below(folder, name));
        continue;
      }
      if (const auto* ledger = Ledger::of_thread()) {
        BOOST_OUTCOME_TRYV(ledger->go_on());
      }
      // A file where the pattern needs a folder, or a folder that leads out, does not match.
      const auto looked = look_for(root, folder);
      if (!looked && looked.error().code != Errc::usage) return looked.error();
      if (!looked || !looked.value() || looked.value()->kind != KindBeneath::folder) continue;
      BOOST_OUTCOME_TRY(names, names_in(root, folder));
      for (const auto& candidate : names)
        if (::fnmatch(name.c_str(), candidate.c_str(), FNM_PERIOD) == 0) next.push_back(below(folder, candidate));
      if (next.size() > files_max) return error(Errc::usage, pattern + ": matches more than a million files");
    }
    found = std::move(next);
  }
  std::vector<std::string> there;
  for (const auto& path : found) {
    // Reports files that the pattern means and that lead out of the root. Missing files are not meant.
    BOOST_OUTCOME_TRY(looked, look_for(root, path));
    if (looked) there.push_back(path);
  }
  return there;
}

Status add_folder(const FileHandle& root, const std::string& folder, bool recursive, std::vector<std::string>& files) {
  BOOST_OUTCOME_TRY(names, names_in(root, folder));
  for (const auto& name : names) {
    const std::string path = below(folder, name);
    // Does not follow links, which may form circles. A link that leads out is reported when the file is opened.
    const auto plain = open_if_there(root, path, O_PATH | O_DIRECTORY, Links::refused);
    if (!plain && plain.error().code != Errc::usage) return plain.error();
    if (plain && plain.value()) {
      BOOST_OUTCOME_TRY(real, real_path(*plain.value()));
      BOOST_OUTCOME_TRY(result, is_result_folder(real));
      if (recursive && !result) {
        BOOST_OUTCOME_TRYV(add_folder(root, path, recursive, files));
      }
    } else if (has_point_file_name(path)) {
      files.push_back(path);
    }
    if (files.size() > files_max) return error(Errc::usage, folder + ": holds more than a million files");
  }
  return success();
}

// The real paths of the files, sorted by their names below the root.
Result<std::vector<std::string>> files_below(const FileHandle& root, const std::string& input, bool recursive) {
  BOOST_OUTCOME_TRYV(Ledger::draw_files(1));
  std::vector<std::string> paths{input.empty() ? "." : input};
  bool pattern = has_pattern(input);
  if (pattern) {  // a file name may hold the characters of a pattern
    const auto named = look_for(root, input);
    if (!named && named.error().code != Errc::usage) return named.error();
    pattern = !named || !named.value();
  }
  if (pattern) {
    if (goes_up(input)) return error(Errc::usage, input + ": a pattern must not contain '..'");
    BOOST_OUTCOME_TRY(expanded, expand(root, input));
    if (expanded.empty()) return error(Errc::io, input + ": no file matches this pattern");
    paths = std::move(expanded);
    std::sort(paths.begin(), paths.end());
  }
  std::vector<std::string> files;
  for (const auto& path : paths) {
    BOOST_OUTCOME_TRY(found, look_at(root, path));
    if (found.kind == KindBeneath::other) return error(Errc::usage, path + ": is neither a file nor a folder");
    if (found.kind == KindBeneath::file) {
      files.push_back(found.real.string());
      continue;
    }
    BOOST_OUTCOME_TRY(result, is_result_folder(found.real));
    if (result)
      return error(Errc::usage, path + ": is a result folder, and holds no input; exporting it makes point files");
    std::vector<std::string> inside;
    BOOST_OUTCOME_TRYV(add_folder(root, path, recursive, inside));
    if (inside.empty()) return error(Errc::io, path + ": holds no point files");
    std::sort(inside.begin(), inside.end());
    for (const auto& file : inside) {
      BOOST_OUTCOME_TRY(one, look_at(root, file));
      if (one.kind != KindBeneath::file) return error(Errc::usage, file + ": is not a file");
      files.push_back(one.real.string());
    }
  }
  return files;
}

}  // namespace

Result<Roots::Root> Roots::open_root(const fs::path& path) {
  BOOST_OUTCOME_TRY(folder, open_folder(path));
  BOOST_OUTCOME_TRY(real, real_path(folder));
  auto given = fs::absolute(path).lexically_normal();
  if (!given.has_filename() && given.has_relative_path()) given = given.parent_path();
  return Root{std::move(given), std::move(real), std::move(folder)};
}

Status check_apart(const fs::path& data, const std::vector<fs::path>& roots) {
  const auto lies_in = [](const fs::path& inner, const fs::path& outer) {
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
  };
  std::error_code missing;
  const auto real_data = fs::weakly_canonical(data, missing);  // it is made later, when everything else is valid
  if (missing) return io_error(data, "cannot be looked at", missing.value());
  for (const auto& root : roots) {
    const auto real = fs::canonical(root, missing);
    if (missing || (!lies_in(real_data, real) && !lies_in(real, real_data))) continue;
    return error(Errc::usage, option("inputs") + ": " + root.string() + " and the data folder " + data.string() +
                                  " must be separate folders, but one of them lies inside the other");
  }
  return success();
}

Result<Roots> Roots::open(const std::vector<fs::path>& roots, const fs::path& uploads) {
  BOOST_OUTCOME_TRYV(check_beneath());
  Roots opened;
  for (const auto& root : roots) {
    BOOST_OUTCOME_TRY(one, open_root(root));
    opened.roots_.push_back(std::move(one));
  }
  if (!uploads.empty()) {
    BOOST_OUTCOME_TRY(one, open_root(uploads));
    opened.uploads_.push_back(std::move(one));
  }
  return opened;
}

std::string Roots::named(std::string sentence) const {
  const auto replace = [&](const fs::path& folder, std::string_view name) {
    const std::string begin = folder.string() == "/" ? "/" : folder.string() + "/";
    const auto in_word = [](char c) { return c != ' ' && c != '\'' && c != '"' && c != '(' && c != ':'; };
    for (auto at = sentence.find(begin); at != sentence.npos; at = sentence.find(begin, at + name.size())) {
      if (at > 0 && in_word(sentence[at - 1])) {  // the same path below another folder
        ++at;
        continue;
      }
      sentence.replace(at, begin.size(), name);
    }
  };
  for (const auto& root : uploads_) {
    replace(root.real, upload_begin);
    replace(root.given, upload_begin);
  }
  for (const auto& root : roots_) {
    replace(root.real, "");
    replace(root.given, "");
  }
  return sentence;
}

namespace {

// The objects that an address stands for, which are those that the operator allows (Objects).
Result<std::vector<std::string>> objects_of(const std::string& address, bool recursive) {
  if (const auto end = address.find_first_of("?#"); end != std::string::npos)
    return error(Errc::usage,
                 "inputs: '" + address.substr(0, address.find_first_of("?#@")) +
                     "' has more behind its path, which may be a signature and would be kept with the job");
  auto names = object_names(address, recursive, Ledger::token_of_thread());
  if (!names) return error(names.error().code, "inputs: " + names.error().where);
  BOOST_OUTCOME_TRYV(Ledger::draw_files(names.value().size()));
  return names;
}

}  // namespace

Result<std::vector<std::string>> Roots::files_of(const std::string& input, bool recursive) const {
  const auto refuse = [&](const std::string& reason) {
    return error(Errc::usage, "inputs: '" + input + "' " + reason);
  };
  if (input.empty()) return error(Errc::usage, "inputs: one of the names is empty");
  if (input == "-") return refuse("is standard input, which a service does not have");
  if (input.find('\0') != std::string::npos) return refuse("holds a zero byte");
  if (names_object(input) && reads_objects()) return objects_of(input, recursive);
  if (input.find("://") != std::string::npos) return refuse("is an address, and the service fetches none: give files");
  const auto told = [](Error wrong) { return error(wrong.code, "inputs: " + wrong.where); };
  if (input.starts_with(upload_begin)) {
    if (uploads_.empty()) return refuse("is an upload, and this service takes no uploads");
    auto files = files_below(uploads_.front().folder, input.substr(upload_begin.size()), recursive);
    if (!files) return told(files.error());
    return files;
  }
  if (roots_.empty()) return refuse("cannot be read: no folder for inputs is configured");
  std::optional<Error> first;
  for (const auto& root : roots_) {
    std::optional<std::string> inside = input;
    if (input.front() == '/') {
      inside = from_folder(input, root.given);
      if (!inside) inside = from_folder(input, root.real);
      if (!inside) continue;
    }
    auto files = files_below(root.folder, *inside, recursive);
    if (files) return files;
    if (!first || files.error().code == Errc::usage) first = files.error();
  }
  if (first) return told(*first);
  return refuse("is not below a folder that is configured for inputs");
}

Result<std::vector<std::string>> Roots::files(const std::vector<std::string>& inputs, bool recursive) const {
  if (inputs.empty()) return error(Errc::usage, "inputs: no file, folder or pattern is given");
  std::vector<std::string> all;
  std::set<std::string> there;
  for (const auto& input : inputs) {
    BOOST_OUTCOME_TRY(files, files_of(input, recursive));
    for (auto& file : files)
      if (there.insert(file).second) all.push_back(std::move(file));
    if (all.size() > files_max) return error(Errc::usage, "inputs: name more than a million files");
  }
  return all;
}

}  // namespace tessera::service
