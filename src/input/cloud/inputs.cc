#include "src/input/cloud/inputs.h"

#include <glob.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <system_error>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/input/bytes/line_reader.h"
#include "src/input/bytes/objects.h"
#include "src/input/ept/ept_names.h"
#include "src/input/format.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

// glob() stops at a folder that cannot be read, but not at one that is missing.
int stops_at(const char*, int number) { return number != ENOENT && number != ENOTDIR ? 1 : 0; }

// Returns the files and folders that match a pattern.
Result<std::vector<std::string>> expand_pattern(const std::string& pattern) {
  // A name may contain the characters of patterns. If a file of this very name exists, the name is meant literally.
  if (pattern.find_first_of("*?[") == std::string::npos) return std::vector{pattern};
  BOOST_OUTCOME_TRY(literally, is_there(pattern, FollowLinks::no));
  if (literally) return std::vector{pattern};
  glob_t found{};
  const int code = ::glob(pattern.c_str(), GLOB_NOSORT, stops_at, &found);
  std::vector<std::string> paths(found.gl_pathv, found.gl_pathv + (code == 0 ? found.gl_pathc : 0));
  ::globfree(&found);
  if (code == GLOB_NOMATCH || (code == 0 && paths.empty()))
    return error(Errc::io, pattern + ": no file matches this pattern");
  if (code != 0) return error(Errc::io, pattern + ": the folders of this pattern cannot be read");
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Adds the point files in `folder`, and in its subfolders if `recursive`. Sets `subfolders` when there are any.
Status add_folder(const fs::path& folder, bool recursive, std::vector<std::string>& files, bool& subfolders) {
  FolderReader reader(folder);
  while (const char* name = reader.next()) {
    const fs::path path = folder / name;
    if (name[0] == '.') continue;
    BOOST_OUTCOME_TRY(below, is_folder(path));  // a link to nothing is no folder; opening it reports the error
    if (below) {
      subfolders = true;
      // Links to folders are not followed, because they may form a circle.
      BOOST_OUTCOME_TRY(itself, is_folder(path, FollowLinks::no));
      BOOST_OUTCOME_TRY(result, is_result_folder(path));
      BOOST_OUTCOME_TRY(ept, is_there(path / ept_file_name));
      if (ept) {
        files.push_back((path / ept_file_name).string());
      } else if (recursive && itself && !result) {
        BOOST_OUTCOME_TRYV(add_folder(path, recursive, files, subfolders));
      }
    } else if (has_point_file_name(path)) {
      files.push_back(path.string());
    }
  }
  if (reader.error()) return error(Errc::io, folder.string() + ": cannot be read: " + reader.error().message());
  return success();
}

Result<std::vector<std::string>> files_of_folder(const std::string& folder, bool recursive) {
  BOOST_OUTCOME_TRY(result, is_result_folder(folder));
  if (result)
    return error(Errc::usage, folder + ": is a result folder, and holds no input; exporting it makes point files");
  const std::string ept = (fs::path(folder) / ept_file_name).string();
  BOOST_OUTCOME_TRY(whole, is_there(ept));
  if (whole) return std::vector{ept};
  std::vector<std::string> files;
  bool subfolders = false;
  BOOST_OUTCOME_TRYV(add_folder(folder, recursive, files, subfolders));
  if (files.empty()) {
    const std::string advice = "; " + option("recursive", "true") + " looks into its subfolders, too";
    return error(Errc::io, folder + ": holds no point files (" + point_file_endings() +
                               ", these with .gz or .zst, and " + ept_file_name + ")" +
                               (subfolders && !recursive ? advice : ""));
  }
  std::sort(files.begin(), files.end());
  return files;
}

Status add_inputs(const std::string& pattern, bool recursive, const std::stop_token& stop, std::vector<InputName>& to) {
  if (names_object(pattern)) {
    BOOST_OUTCOME_TRY(names, object_names(pattern, recursive, stop));
    for (auto& name : names) to.push_back({.path = std::move(name)});
    return success();
  }
  BOOST_OUTCOME_TRY(paths, expand_pattern(pattern));
  for (const auto& path : paths) {
    BOOST_OUTCOME_TRY(folder, is_folder(path));
    if (!folder) {
      to.push_back({.path = path});
      continue;
    }
    BOOST_OUTCOME_TRY(files, files_of_folder(path, recursive));
    const bool ept = fs::path(files.front()).filename() == ept_file_name;  // then it is the only one
    const std::string behind = ept ? ""
                                   : " (it was found in the folder " + path +
                                         "; to leave it out, name the others, as in '" +
                                         (fs::path(path) / "*.las").string() + "')";
    for (auto& file : files) to.push_back({.path = std::move(file), .behind = behind});
  }
  return success();
}

Status add_list(const std::string& list, bool recursive, Spool& spool, std::vector<InputName>& to) {
  std::unique_ptr<ByteSource> source;
  if (list == "-") {
    BOOST_OUTCOME_TRY(opened, spool.standard_input());
    source = share(std::move(opened));
  } else if (names_object(list)) {
    BOOST_OUTCOME_TRY(opened, open_object(list, spool.stop()));
    source = share(std::move(opened));
  } else {
    BOOST_OUTCOME_TRY(opened, open_file(list));
    source = std::move(opened);
  }
  const std::string name = source->path().string();
  const fs::path folder = list == "-" ? fs::path() : fs::path(list).parent_path();
  const std::size_t before = to.size();
  LineReader lines(std::move(source));
  while (true) {
    BOOST_OUTCOME_TRY(line, lines.next());
    if (!line) break;
    if (lines.number() == 1 && line->starts_with("\xEF\xBB\xBF")) line->remove_prefix(3);  // UTF-8 BOM
    const auto first = line->find_first_not_of(" \t");
    if (first == std::string_view::npos || (*line)[first] == '#') continue;
    const auto entry = line->substr(first, line->find_last_not_of(" \t") + 1 - first);
    if (entry.find('\0') != std::string_view::npos) return lines.bad_line("is no file name: it holds a zero byte");
    const std::string place = name + ", line " + std::to_string(lines.number()) + ": ";
    const std::size_t added = to.size();
    if (names_object(list) && !names_object(entry) && entry[0] == '/')
      return lines.bad_line("names a file of this machine, which a list on a server must not do");
    const std::string meant = names_object(entry) ? std::string(entry) : (folder / fs::path(entry)).string();
    const auto status = add_inputs(meant, recursive, spool.stop(), to);
    if (status.has_error()) return Error{status.error().code, place + status.error().where};
    for (std::size_t i = added; i < to.size(); ++i) to[i].before = place;
  }
  if (to.size() == before) return error(Errc::bad_input, name + ": names no input file");
  return success();
}

// Whether a name is that of a result in a store. The server is not asked about names of point files and lists.
Result<bool> is_far_result(const fs::path& name) {
  const std::string text = name.string();
  const auto named = named_version(name);
  if (text.find_first_of("?#") != std::string::npos || text.ends_with("://")) return false;
  if (!named && (has_point_file_name(name) || name.extension() == ".json" || name.extension() == ".geojson"))
    return false;
  return object_exists(manifest_file(named ? named->out : name).string(), {});
}

}  // namespace

Result<bool> is_result_folder(const fs::path& folder) {
  if (names_object(folder.string())) return is_far_result(folder);
  if (const auto named = named_version(folder)) return is_there(manifest_file(named->out));
  for (const auto& inside : {run_folder(folder), lock_folder(folder)}) {
    BOOST_OUTCOME_TRY(there, is_folder(inside));
    if (there) return true;
  }
  // A file manifest.json alone is no sign, because other programs write such files, too.
  for (const auto& beside : {master_file(folder), tiles_folder(folder)}) {
    BOOST_OUTCOME_TRY(there, is_there(beside));
    if (there) return is_there(manifest_file(folder));
  }
  return false;
}

Result<std::vector<InputName>> find_inputs(const InputQuestion& question, Spool& spool) {
  std::vector<InputName> inputs;
  const auto times = std::count(question.patterns.begin(), question.patterns.end(), "-") + (question.list == "-");
  if (times > 1) return error(Errc::usage, "standard input ('-') can be read once only");
  for (const auto& pattern : question.patterns) {
    if (pattern == "-") {
      inputs.push_back({.path = pattern, .standard_input = true});
    } else {
      BOOST_OUTCOME_TRYV(add_inputs(pattern, question.recursive, spool.stop(), inputs));
    }
  }
  if (!question.list.empty()) {
    BOOST_OUTCOME_TRYV(add_list(question.list, question.recursive, spool, inputs));
  }
  if (inputs.empty()) return error(Errc::usage, "no input file was given");
  return inputs;
}

}  // namespace tessera
