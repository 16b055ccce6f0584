#include "src/input/format.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <utility>

#include "src/input/ept/ept_names.h"
#include "src/input/fits/fits_header.h"
#include "src/input/mesh/obj_reader.h"
#include "src/input/mesh/off_reader.h"
#include "src/input/mesh/stl_reader.h"
#include "src/input/pcd/pcd_reader.h"
#include "src/input/snapshot/gadget.h"
#include "src/input/snapshot/gadget_hdf5.h"
#include "src/input/snapshot/tipsy.h"

namespace tessera {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

constexpr std::array<std::pair<std::string_view, FileFormat>, 23> endings{
    {{".las", FileFormat::las},  {".laz", FileFormat::las},       {".ply", FileFormat::ply},
     {".off", FileFormat::off},  {".obj", FileFormat::obj},       {".stl", FileFormat::stl},
     {".npy", FileFormat::npy},  {".pcd", FileFormat::pcd},       {".e57", FileFormat::e57},
     {".ptx", FileFormat::ptx},  {".xyz", FileFormat::text},      {".csv", FileFormat::text},
     {".tsv", FileFormat::text}, {".txt", FileFormat::text},      {".asc", FileFormat::text},
     {".pts", FileFormat::pts},  {".gadget", FileFormat::gadget}, {".hdf5", FileFormat::hdf5},
     {".h5", FileFormat::hdf5},  {".tipsy", FileFormat::tipsy},   {".fits", FileFormat::fits},
     {".fit", FileFormat::fits}, {".dat", FileFormat::text}}};

FileFormat format_of_name(const std::filesystem::path& name) {
  if (name.filename() == ept_file_name) return FileFormat::ept;
  const std::string extension = lower_extension(name);
  for (const auto& [ending, format] : endings)
    if (ending == extension) return format;
  return FileFormat::unknown;
}

std::string listed_endings(std::optional<FileFormat> format) {
  std::string list;
  for (const auto& [ending, of] : endings)
    if (!format || of == *format) list.append(list.empty() ? "" : ", ").append(ending);
  return list;
}

bool looks_like_text(std::string_view begin) {
  return std::all_of(begin.begin(), begin.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 || c == '\t' || c == '\n' || c == '\r' || c == '\f';
  });
}

}  // namespace

FileFormat format_of(std::span<const std::byte> begin, const std::filesystem::path& name,
                     std::optional<std::uint64_t> size) {
  const std::string_view bytes(reinterpret_cast<const char*>(begin.data()), begin.size());
  if (bytes.starts_with("LASF")) return FileFormat::las;
  if (bytes.starts_with("\x93NUMPY")) return FileFormat::npy;
  if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return FileFormat::ply;
  if (bytes.starts_with("\x1f\x8b")) return FileFormat::gzip;
  // Zstandard: a frame, or a skippable frame, which parallel compressors write first.
  if (bytes.starts_with("\x28\xb5\x2f\xfd")) return FileFormat::zstd;
  if (bytes.size() >= 4 && (bytes[0] & 0xf0) == 0x50 && bytes.substr(1, 3) == "\x2a\x4d\x18") return FileFormat::zstd;
  if (bytes.starts_with("ASTM-E57")) return FileFormat::e57;
  if (fits::looks_like_fits(bytes)) return FileFormat::fits;
  if (snapshot::looks_like_hdf5(begin)) return FileFormat::hdf5;
  if (snapshot::looks_like_gadget(begin)) return FileFormat::gadget;
  if (snapshot::is_tipsy(begin, size)) return FileFormat::tipsy;
  if (looks_like_pcd(bytes)) return FileFormat::pcd;
  if (looks_like_off(bytes)) return FileFormat::off;
  if (looks_like_obj(bytes)) return FileFormat::obj;
  if (looks_like_text_stl(bytes) || (size && is_binary_stl(begin, size))) return FileFormat::stl;
  if (name.empty() && !size && is_binary_stl(begin, {})) return FileFormat::stl;
  if (name.empty()) return looks_like_text(bytes) ? FileFormat::text : FileFormat::unknown;
  return format_of_name(name);
}

bool has_point_file_name(const std::filesystem::path& path) {
  return format_of_name(without_packing(path)) != FileFormat::unknown;
}

std::filesystem::path without_packing(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension != ".gz" && extension != ".zst") return path;
  return path.parent_path() / path.stem();
}

std::string point_file_endings() { return listed_endings({}); }

Error unknown_format(const std::filesystem::path& path) {
  return error(Errc::bad_input, path.string() +
                                    ": unknown format: its first bytes are not those of LAS, PLY, E57, PCD, OFF, OBJ, "
                                    "STL, NumPy, FITS, HDF5, Gadget, Tipsy, "
                                    "gzip or Zstandard, its name does not end like that of a text (" +
                                    listed_endings(FileFormat::text) + "), and it is not the " + ept_file_name +
                                    " of EPT");
}

}  // namespace tessera
