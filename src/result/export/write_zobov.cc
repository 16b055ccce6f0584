#include <cmath>
#include <cstring>
#include <limits>

#include "src/base/attribute_value.h"
#include "src/base/image.h"
#include "src/base/option.h"
#include "src/result/export/formats.h"
#include "src/result/export/point_table.h"
#include "src/result/export/zobov.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

Error refuse(const MeshSource& source, const std::string& why) {
  return error(Errc::usage, source.out.string() + ": " + why);
}

Status check_zobov(const MeshSource& source, const std::string& column, std::uint64_t most) {
  const Manifest& manifest = source.manifest;
  if (const std::uint64_t points = manifest.vertices + manifest.duplicates; points > most)
    return refuse(source, "has " + std::to_string(points) + " points, and the numbers in ZOBOV's files end at " +
                              std::to_string(most));
  if (source.tiles->period().open_axes(manifest.dimension) > 0)
    return refuse(source,
                  "is not periodic along all axes, so points at its hull have cells without end, and ZOBOV's files "
                  "cannot say so; triangulate with " +
                      option("periodic"));
  if (!column_of(manifest.schema, column))
    return refuse(source,
                  "has no volumes of Voronoi cells; measuring it with " + option("voronoi", "true") + " computes them");
  return success();
}

Status check_places(const MeshSource& source, const PointTable& table) {
  const auto duplicates = table.duplicates();
  for (std::size_t i = zobov_most_at_one_place - 1; i < duplicates.size(); ++i)
    if (duplicates[i].kept == duplicates[i + 1 - zobov_most_at_one_place].kept)
      return refuse(source, "has more than " + std::to_string(zobov_most_at_one_place) +
                                " points at the place of point " + to_string(duplicates[i].kept) +
                                ", each of which would be a neighbour of all others");
  return success();
}

// The unit of volumes: the mean.
double mean_volume(const MeshSource& source, std::uint64_t rows) {
  double box = 1;
  for (int axis = 0; axis < source.manifest.dimension; ++axis)
    box *= source.tiles->period().length[static_cast<std::size_t>(axis)];
  return box / static_cast<double>(rows);
}

Status check_volume(const MeshSource& source, PointId id, double volume, ZobovNumbers numbers) {
  const bool fits = numbers == ZobovNumbers::doubles
                        ? std::isnormal(volume)
                        : std::isfinite(static_cast<float>(volume)) && std::isnormal(static_cast<float>(volume));
  if (fits && volume > 0) return success();
  return refuse(source, "the volume of point " + to_string(id) + ", " + std::to_string(volume) +
                            " of the mean, cannot be written" +
                            (numbers == ZobovNumbers::floats ? " in 32 bits; zobov64 has more" : ""));
}

// Writes PREFIX.vol, and finds the number of each id.
Status write_volumes(const MeshSource& source, const PointTable& table, ZobovNumbers numbers, const OutputFile& file,
                     RowNumbers& rows) {
  Stream stream(file, 0);
  stream.value(static_cast<std::int32_t>(table.rows()));
  const std::size_t volume_at = table.columns().back().offset;
  const double mean = mean_volume(source, table.rows());
  BOOST_OUTCOME_TRYV(table.for_each(folder_of(file.target()), [&](std::span<const std::byte> some) -> Status {
    for (std::size_t at = 0; at < some.size(); at += table.row_bytes()) {
      const std::byte* row = some.data() + at;
      PointId id;
      double volume = 0;
      std::memcpy(&id, row, sizeof id);
      std::memcpy(&volume, row + volume_at, sizeof volume);
      rows.add(id);
      volume = volume / mean / static_cast<double>(table.points_at(table.vertex_of(row)));
      BOOST_OUTCOME_TRYV(check_volume(source, id, volume, numbers));
      if (numbers == ZobovNumbers::floats) {
        stream.value(static_cast<float>(volume));
      } else {
        stream.value(volume);
      }
    }
    return stream.status();
  }));
  return stream.flush();
}

}  // namespace

Result<Exported> write_zobov_files(const MeshSource& source, const fs::path& path, ZobovNumbers numbers,
                                   std::uint64_t most) {
  const std::string column = source.manifest.dimension == 2 ? "voronoi_area" : "voronoi_volume";
  BOOST_OUTCOME_TRYV(check_zobov(source, column, most));
  BOOST_OUTCOME_TRY(table, PointTable::open(source, {column}));
  BOOST_OUTCOME_TRYV(check_places(source, table));
  BOOST_OUTCOME_TRY(volumes, OutputFile::create(path));
  BOOST_OUTCOME_TRY(neighbours, OutputFile::create(fs::path(path).replace_extension(".adj")));
  RowNumbers rows(source.manifest.points_read, table.rows());
  BOOST_OUTCOME_TRYV(write_volumes(source, table, numbers, volumes, rows));
  BOOST_OUTCOME_TRYV(write_zobov_neighbours(source, table, rows, neighbours));
  Exported exported;
  BOOST_OUTCOME_TRY(bytes_of_neighbours, neighbours.finish());
  BOOST_OUTCOME_TRY(bytes_of_volumes, volumes.finish());
  exported.bytes = bytes_of_volumes + bytes_of_neighbours;
  exported.vertices = table.rows();
  exported.files = 2;
  return exported;
}

Result<Exported> write_zobov(const MeshSource& source, const fs::path& path) {
  return write_zobov_files(source, path, ZobovNumbers::floats);
}

Result<Exported> write_zobov_doubles(const MeshSource& source, const fs::path& path) {
  return write_zobov_files(source, path, ZobovNumbers::doubles);
}

}  // namespace tessera::exports
