#include "src/io/reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

#include "src/io/byte_source.h"
#include "src/io/las_reader.h"
#include "src/io/npy_reader.h"
#include "src/io/ply_reader.h"
#include "src/io/text_reader.h"

namespace tessera {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_text_extension(std::string_view extension) {
  constexpr std::array<std::string_view, 7> known{".xyz", ".csv", ".tsv", ".txt", ".asc", ".pts", ".dat"};
  return std::find(known.begin(), known.end(), extension) != known.end();
}

}  // namespace

Result<std::unique_ptr<PointReader>> open_reader(std::unique_ptr<ByteSource> source,
                                                 const std::vector<Attribute>& attributes, const ReadHints& hints) {
  const auto path = source->path();
  if (source->size() == 0) return error(Errc::bad_input, path.string() + ": is empty");
  std::array<char, 6> magic{};
  const auto there = static_cast<std::size_t>(std::min<std::uint64_t>(magic.size(), source->size()));
  BOOST_OUTCOME_TRYV(source->read(0, std::as_writable_bytes(std::span(magic)).first(there)));
  const std::string_view begin(magic.data(), there);
  const std::string extension = lower_extension(path);

  if (begin.starts_with("LASF") || extension == ".las" || extension == ".laz")
    return open_las(std::move(source), attributes, hints);
  if (begin == "\x93NUMPY" || extension == ".npy") return open_npy(std::move(source), attributes);
  if (begin.starts_with("ply\n") || begin.starts_with("ply\r") || extension == ".ply")
    return open_ply(std::move(source), attributes);
  if (is_text_extension(extension)) return open_text(std::move(source), attributes);
  return error(Errc::bad_input, path.string() +
                                    ": unknown format: neither LAS, PLY nor NumPy by its first bytes, nor " +
                                    "text by its name (.xyz, .csv, .tsv, .txt, .asc, .pts, .dat)");
}

Result<std::unique_ptr<PointReader>> open_reader(const std::filesystem::path& path,
                                                 const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRY(source, open_file(path));
  return open_reader(std::move(source), attributes, hints);
}

}  // namespace tessera
