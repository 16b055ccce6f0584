#include "src/result/export/export.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/result/export/mesh_reader.h"
#include "src/result/export/target.h"

namespace tessera {

namespace fs = std::filesystem;

namespace exports {
namespace {

// Error usage when `folder` has files of an older export that the files in `names` will not replace.
Status check_leftovers(const fs::path& folder, const Format& format, const std::set<std::string>& names) {
  FolderReader reader(folder);
  while (const char* name = reader.next())
    if (fs::path(name).extension() == format.ending && !names.contains(name))
      return error(Errc::usage,
                   (folder / name).string() +
                       ": is a file of an older export, and would stay among the new files; remove it first");
  if (reader.error() && reader.error() != std::errc::no_such_file_or_directory)
    return io_error(folder, "cannot be listed", reader.error().value());
  return success();
}

// A folder under a temporary name. The destructor removes it with its contents, unless it was moved to its place.
class NewFolder {
 public:
  static Result<NewFolder> create(const fs::path& target) {
    BOOST_OUTCOME_TRY(temporary, TemporaryFolder::make(temporary_name_of_process(target)));
    return NewFolder(target, std::move(temporary));
  }
  const fs::path& path() const { return temporary_.path(); }

  // Moves the whole folder if the target does not exist; else moves the files one by one into the target.
  Status publish() {
    BOOST_OUTCOME_TRY(there, is_there(target_));
    if (!there) {
      BOOST_OUTCOME_TRYV(rename_file(path(), target_));
    } else {
      FolderReader reader(path());
      while (const char* name = reader.next()) {
        BOOST_OUTCOME_TRYV(rename_file(path() / name, target_ / name));
      }
      if (reader.error()) return io_error(target_, "cannot be written", reader.error().value());
    }
    return sync_folder(target_);
  }

 private:
  NewFolder(fs::path target, TemporaryFolder temporary)
      : target_(std::move(target)), temporary_(std::move(temporary)) {}
  fs::path target_;
  TemporaryFolder temporary_;
};

// Passes to a writer all that its head announces.
using Give = std::function<Status(MeshWriter&)>;

Result<Exported> export_file(const Format& format, const MeshHead& head, const Target& target, const Give& give) {
  Exported exported;
  exported.files = 1;
  BOOST_OUTCOME_TRY(writer, format.open(target.path, head));
  BOOST_OUTCOME_TRYV(give(*writer));
  if (!format.index_of_one) {
    BOOST_OUTCOME_TRY(bytes, writer->finish());
    exported.bytes = bytes;
    return exported;
  }
  // Both files are complete before either gets its name.
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

// Writes no files for tiles of which the filter leaves nothing.
Result<Exported> export_tiles(const MeshSource& source, const Selection& selection, const Target& target) {
  std::vector<std::size_t> written;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < selection.ranges.size(); ++i) {
    const auto& range = selection.ranges[i];
    if (source.filter.active() && range.cells == 0) continue;
    written.push_back(i);
    names.push_back(tile_file("", range.tile).filename().replace_extension(source.format.ending));
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

Result<Exported> export_arrays(const Format& format, const MeshHead& head, const Target& target, const Give& give) {
  BOOST_OUTCOME_TRY(folder, NewFolder::create(target.path));
  Exported exported;
  BOOST_OUTCOME_TRY(writer, format.open(folder.path(), head));
  BOOST_OUTCOME_TRYV(give(*writer));
  BOOST_OUTCOME_TRY(bytes, writer->finish());
  exported.bytes = bytes;
  std::set<std::string> names;
  FolderReader reader(folder.path());
  while (const char* name = reader.next()) names.insert(name);
  if (reader.error()) return io_error(target.path, "cannot be written", reader.error().value());
  BOOST_OUTCOME_TRYV(check_leftovers(target.path, format, names));
  exported.files = names.size();
  BOOST_OUTCOME_TRYV(folder.publish());
  return exported;
}

// Exports to one file, or to one folder of arrays.
Result<Exported> export_merged(const MeshSource& source, const Selection& selection, const Target& target,
                               const Give& give) {
  const MeshHead head = head_of(source, selection);
  return target.folder ? export_arrays(source.format, head, target, give)
                       : export_file(source.format, head, target, give);
}

// A note about what the format could not keep.
std::string note_of(const MeshSource& source) {
  const Manifest& manifest = source.manifest;
  if (source.format.crs) return crs_note(manifest.crs);
  if (!source.format.floats || source.options.local) return {};
  double size = 0, far = 0;
  for (int axis = 0; axis < manifest.dimension; ++axis) {
    size = std::max(size, manifest.bounds.hi[axis] - manifest.bounds.lo[axis]);
    far = std::max({far, std::abs(manifest.bounds.lo[axis]), std::abs(manifest.bounds.hi[axis])});
  }
  const double step = std::ldexp(far, -23);
  if (step < size * 1e-5) return {};
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "%s holds floats of 32 bits, in steps of up to %.2g here: local coordinates would be finer",
                source.format.name, step);
  return text.data();
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
  BOOST_OUTCOME_TRY(tiles, TileSource::open(out, Periods::known));
  const Manifest& manifest = tiles.manifest();
  BOOST_OUTCOME_TRYV(exports::check_fits(out, manifest, *target.format));
  const exports::MeshSource source{.out = out,
                                   .tiles = &tiles,
                                   .manifest = manifest,
                                   .format = *target.format,
                                   .options = options,
                                   .filter = exports::CellFilter({options.max_edge, options.max_radius}),
                                   .stop = stop};
  if (target.format->write != nullptr) {
    BOOST_OUTCOME_TRY(exported, target.format->write(source, target.path));
    exported.path = target.path;
    return exported;
  }
  const bool by_tile = target.folder && target.format->shape == exports::Shape::file;
  BOOST_OUTCOME_TRY(selection, exports::select(source, !by_tile && !target.format->corners));
  const auto give = [&](exports::MeshWriter& writer) { return exports::read_merged(source, selection, writer); };
  BOOST_OUTCOME_TRY(exported, by_tile ? exports::export_tiles(source, selection, target)
                                      : exports::export_merged(source, selection, target, give));
  exported.path = target.path;
  exported.vertices = selection.vertices;
  exported.cells = selection.cells;
  exported.left_out = manifest.cells - selection.cells;
  exported.corner = exports::corner_of(source);
  exported.note = exports::note_of(source);
  return exported;
}

Result<std::uint64_t> estimate_export(const Manifest& manifest, const fs::path& target, const ExportOptions& options) {
  BOOST_OUTCOME_TRY(format, exports::find_format(target, options.format));
  // Numbers as text have up to 18 digits; ids of large results have 9.
  constexpr std::uint64_t coordinates = 54, number = 10;
  const std::uint64_t corners = static_cast<std::uint64_t>(manifest.dimension) + 1;
  const std::uint64_t vertex = coordinates + 3 * row_bytes(manifest.schema);
  const std::uint64_t columns = format->cell_columns ? 3 * row_bytes(cell_schema_of(manifest)) : 0;
  if (format->corners)
    return manifest.cells * ((corners + 1) * coordinates + columns) +
           (format->vertex_layer ? manifest.vertices * vertex : 0);
  return manifest.vertices * vertex +
         manifest.cells * (corners * number * (format->neighbors ? 2 : 1) + number + columns);
}

Result<Exported> export_cells(const fs::path& out, const Manifest& manifest, StoredTile& cells,
                              std::span<const TileId> tiles, const fs::path& path, const ExportOptions& options,
                              std::stop_token stop) {
  ExportOptions of_cells = options;
  of_cells.cells_only = true;
  BOOST_OUTCOME_TRY(target, exports::find_free_target(path, of_cells));
  BOOST_OUTCOME_TRYV(exports::check_fits(out, manifest, *target.format));
  if (target.folder && target.format->shape == exports::Shape::file)
    return error(Errc::usage, path.string() + ": is a folder or has no ending, and cells go to one file: add " +
                                  target.format->ending);
  const exports::MeshSource source{.out = out,
                                   .tiles = nullptr,
                                   .manifest = manifest,
                                   .format = *target.format,
                                   .options = options,
                                   .filter = exports::CellFilter(exports::CellSizes{}),
                                   .stop = stop};
  const auto selection = exports::select_all(cells.mesh, tiles);
  const auto give = [&](exports::MeshWriter& writer) {
    return exports::write_cells(source, selection, cells, tiles, writer);
  };
  BOOST_OUTCOME_TRY(exported, exports::export_merged(source, selection, target, give));
  exported.path = target.path;
  exported.vertices = selection.vertices;
  exported.cells = selection.cells;
  exported.note = exports::note_of(source);
  return exported;
}

std::set<std::string> export_endings(const fs::path& path, const std::string& format_name) {
  std::set<std::string> endings;
  for (const auto& format : exports::formats()) {
    const bool meant = format_name.empty() ? path.extension() == format.ending || path.extension() == format.ending2
                                           : format_name == format.name;
    if (!meant) continue;
    endings.insert(format.ending);
    if (format.index_of_one) endings.insert(format.index_ending);
  }
  return endings;
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
