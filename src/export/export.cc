#include "src/export/export.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/crs/crs.h"
#include "src/export/mesh_reader.h"
#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/temporary.h"
#include "src/files/whole_file.h"

namespace tessera {

namespace fs = std::filesystem;

namespace exports {
namespace {

// Where the result goes: a file, or a folder.
struct Target {
  const Format* format = nullptr;
  fs::path path;
  bool folder = false;
};

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

const Format* find_format(const std::string& name, const std::string& ending) {
  for (const auto& format : formats()) {
    if (!name.empty() ? name == format.name : ending == format.ending || ending == format.ending2) return &format;
  }
  return nullptr;
}

Result<Target> find_target(const fs::path& path, const std::string& name) {
  std::error_code code;
  Target target{.path = path.has_filename() ? path : path.parent_path()};
  const std::string ending = lower(path.extension().string());
  target.folder = !path.has_filename() || ending.empty() || fs::is_directory(path, code);
  if (name.empty() && target.folder)
    return error(Errc::usage, path.string() + ": is a folder or has no ending, so give " + option("format") + ": " +
                                  export_format_names());
  target.format = find_format(name, ending);
  if (target.format == nullptr)
    return error(Errc::usage, "'" + (name.empty() ? ending.substr(1) : name) + "' is not a format to export to: give " +
                                  export_format_names());
  if (target.format->shape == Shape::folder && !target.folder)
    return error(Errc::usage, path.string() + ": " + target.format->name +
                                  " is a folder of arrays: give a name without an ending, and " +
                                  option("format", target.format->name));
  // The table of a .vrt has the same name.
  if (!target.folder && ending == target.format->ending2) target.path.replace_extension(target.format->ending);
  return target;
}

fs::path index_beside(const Target& target) {
  return fs::path(target.path).replace_extension(target.format->index_ending);
}

Status check_free(const Target& target, bool overwrite) {
  std::error_code code;
  if (!target.folder && target.format->index_of_one && fs::is_directory(index_beside(target), code))
    return error(Errc::usage,
                 index_beside(target).string() + ": is a folder, and a file of that name is to be written");
  if (overwrite) return success();
  const auto taken = [](const fs::path& path) {
    return error(Errc::usage, path.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  };
  if (target.folder) {
    if (fs::exists(target.path, code) && !fs::is_empty(target.path, code))
      return error(Errc::usage, target.path.string() + ": is not empty; " + option("overwrite", "true") +
                                    " replaces files of the same names");
    return success();
  }
  if (fs::exists(target.path, code)) return taken(target.path);
  if (target.format->index_of_one && fs::exists(index_beside(target), code)) return taken(index_beside(target));
  return success();
}

Status check_fits(const fs::path& out, const Manifest& manifest, const Format& format) {
  const auto advise = [&](const std::string& why) {
    return error(Errc::usage, out.string() + ": " + why + "; " + format.instead + " can");
  };
  if (manifest.dimension == 3 && !format.in_3d)
    return advise(std::string("is a 3D result, and ") + format.name + " has no tetrahedra");
  if (manifest.region && !manifest.region->complete && !format.final)
    return error(Errc::usage, out.string() + ": is a part whose cells are not all final, and " + format.name +
                                  " cannot tell which are; vtu, npy and geojson can");
  if (std::max(manifest.vertices, manifest.cells) > format.most)
    return advise("has more vertices or cells than the " + std::to_string(format.most) + " that readers of " +
                  format.name + " can number");
  return success();
}

// Error usage when `folder` has files of an older export that those named will not replace.
Status check_leftovers(const fs::path& folder, const Format& format, const std::set<std::string>& names) {
  FolderReader reader(folder);
  while (const char* name = reader.next())
    if (fs::path(name).extension() == format.ending && !names.contains(name))
      return error(Errc::usage, (folder / name).string() + ": would stay among the new files; remove it first");
  return success();
}

// A folder under a temporary name, removed with all that is in it unless it was moved to its place.
class NewFolder {
 public:
  static Result<NewFolder> create(const fs::path& target) {
    BOOST_OUTCOME_TRY(temporary, TemporaryFolder::make(temporary_name_of_process(target)));
    return NewFolder(target, std::move(temporary));
  }
  const fs::path& path() const { return temporary_.path(); }

  // As a whole when there is none of that name; else file by file into it.
  Status publish() {
    std::error_code code;
    if (!fs::exists(target_, code)) {
      fs::rename(path(), target_, code);
    } else {
      FolderReader reader(path());
      const char* name = nullptr;
      while (!code && (name = reader.next()) != nullptr) fs::rename(path() / name, target_ / name, code);
      if (!code) code = reader.error();
    }
    if (code) return error(Errc::io, target_.string() + ": cannot be written: " + code.message());
    return sync_folder(target_);
  }

 private:
  NewFolder(fs::path target, TemporaryFolder temporary)
      : target_(std::move(target)), temporary_(std::move(temporary)) {}
  fs::path target_;
  TemporaryFolder temporary_;
};

Result<Exported> export_file(const MeshSource& source, Selection& selection, const Target& target) {
  const Format& format = source.format;
  const MeshHead head = head_of(source, selection);
  Exported exported;
  exported.files = 1;
  BOOST_OUTCOME_TRY(writer, format.open(target.path, head));
  BOOST_OUTCOME_TRYV(read_merged(source, selection, *writer));
  if (!format.index_of_one) {
    BOOST_OUTCOME_TRY(bytes, writer->finish());
    exported.bytes = bytes;
    return exported;
  }
  // Both files are whole before either gets its name.
  const std::string text = format.index(head, {target.path.filename().string()});
  TemporaryFile index(temporary_name(index_beside(target)));
  BOOST_OUTCOME_TRYV(write_whole(index.path(), text));
  BOOST_OUTCOME_TRY(bytes, writer->finish());
  BOOST_OUTCOME_TRYV(publish(index.path(), index_beside(target)));
  index.keep();
  exported.bytes = bytes + text.size();
  ++exported.files;
  return exported;
}

// Of tiles from which the filter leaves nothing there are no files.
Result<Exported> export_tiles(const MeshSource& source, const Selection& selection, const Target& target) {
  std::vector<std::size_t> written;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < selection.parts.size(); ++i) {
    const auto& part = selection.parts[i];
    if (source.filter.active() && part.cells == 0) continue;
    written.push_back(i);
    names.push_back(tile_file("", part.tile).filename().replace_extension(source.format.ending));
  }
  BOOST_OUTCOME_TRYV(check_leftovers(target.path, source.format, {names.begin(), names.end()}));
  BOOST_OUTCOME_TRY(folder, NewFolder::create(target.path));
  Exported exported;
  std::uint64_t done = 0;
  for (std::size_t i = 0; i < written.size(); ++i) {
    BOOST_OUTCOME_TRY(bytes, write_piece(source, selection, written[i], folder.path() / names[i], done));
    exported.bytes += bytes;
  }
  if (source.format.index != nullptr) {
    const MeshHead head = head_of(source, selection);
    const std::string text = source.format.index(head, names);
    const auto name = std::string("triangulation") + source.format.index_ending;
    BOOST_OUTCOME_TRYV(write_whole(folder.path() / name, text));
    exported.bytes += text.size();
    names.push_back(name);
  }
  exported.files = names.size();
  BOOST_OUTCOME_TRYV(folder.publish());
  return exported;
}

Result<Exported> export_arrays(const MeshSource& source, Selection& selection, const Target& target) {
  BOOST_OUTCOME_TRY(folder, NewFolder::create(target.path));
  Exported exported;
  BOOST_OUTCOME_TRY(writer, source.format.open(folder.path(), head_of(source, selection)));
  BOOST_OUTCOME_TRYV(read_merged(source, selection, *writer));
  BOOST_OUTCOME_TRY(bytes, writer->finish());
  exported.bytes = bytes;
  std::set<std::string> names;
  FolderReader reader(folder.path());
  while (const char* name = reader.next()) names.insert(name);
  BOOST_OUTCOME_TRYV(check_leftovers(target.path, source.format, names));
  exported.files = names.size();
  BOOST_OUTCOME_TRYV(folder.publish());
  return exported;
}

}  // namespace
}  // namespace exports

namespace exports {
namespace {

Result<Target> find_free_target(const fs::path& path, const ExportOptions& options) {
  BOOST_OUTCOME_TRY(target, find_target(path, options.format));
  BOOST_OUTCOME_TRYV(check_free(target, options.overwrite));
  if (options.max_edge && !(std::isfinite(*options.max_edge) && *options.max_edge > 0))
    return error(Errc::usage, option("max-edge") + ": must be a length, finite and above 0");
  return std::move(target);
}

}  // namespace
}  // namespace exports

Result<ExportTarget> find_export_target(const fs::path& path, const ExportOptions& options) {
  BOOST_OUTCOME_TRY(target, exports::find_free_target(path, options));
  return ExportTarget{target.path, target.folder};
}

Result<Exported> export_result(const fs::path& out, const fs::path& path, const ExportOptions& options,
                               std::stop_token stop) {
  BOOST_OUTCOME_TRY(target, exports::find_free_target(path, options));
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  BOOST_OUTCOME_TRYV(exports::check_fits(out, manifest, *target.format));
  const exports::MeshSource source{.out = out,
                                   .manifest = manifest,
                                   .format = *target.format,
                                   .options = options,
                                   .filter = exports::CellFilter(options.max_edge),
                                   .stop = stop};
  const bool by_tile = target.folder && target.format->shape == exports::Shape::file;
  BOOST_OUTCOME_TRY(selection, exports::select(source, !by_tile && !target.format->corners));
  BOOST_OUTCOME_TRY(exported, !target.folder ? export_file(source, selection, target)
                              : by_tile      ? export_tiles(source, selection, target)
                                             : export_arrays(source, selection, target));
  exported.path = target.path;
  exported.vertices = selection.vertices;
  exported.cells = selection.cells;
  exported.left_out = manifest.cells - selection.cells;
  if (target.format->crs) exported.note = crs_note(manifest.crs);
  return exported;
}

std::string export_format_names() {
  std::string names;
  for (const auto& format : exports::formats()) names += (names.empty() ? "" : ", ") + std::string(format.name);
  return names;
}

std::string export_format_help() {
  std::string help;
  for (const auto& format : exports::formats()) {
    std::string name = format.name;
    name.resize(8, ' ');
    help += "  " + name + "  " + format.summary + "\n";
  }
  return help;
}

}  // namespace tessera
