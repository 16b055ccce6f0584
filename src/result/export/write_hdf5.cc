// HDF5, laid out as a snapshot of Gadget, which yt, h5py and Tessera itself read: all points are particles of type 1.
#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <vector>

#include "src/base/hdf5/hdf5_output.h"
#include "src/base/image.h"
#include "src/result/export/formats.h"
#include "src/result/export/output.h"
#include "src/result/export/point_table.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t particle_types = 6, type_of_all = 1;

// A table of the file: successive columns of the rows.
struct Part {
  std::size_t offset = 0, bytes = 0;  // in the row
  std::size_t row_bytes = 0;          // in the file: what the row lacks is 0
  std::uint64_t numbers = 1;          // in the file, of a row
};

// The header of a snapshot. What Tessera does not know, such as the cosmology, is 0, as in snapshots without one.
Hdf5Group snapshot_header(const MeshSource& source, std::uint64_t rows, bool masses) {
  const auto of_type = [](auto value) {
    std::vector<decltype(value)> values(particle_types);
    values[type_of_all] = value;
    return values;
  };
  const auto count = static_cast<std::int64_t>(rows);
  constexpr int low_bits = 32;
  Hdf5Group header{.name = "Header", .attributes = {}};
  auto& attributes = header.attributes;
  attributes.push_back({"NumPart_ThisFile", of_type(count)});
  attributes.push_back({"NumPart_Total", of_type(count & ((std::int64_t{1} << low_bits) - 1))});
  attributes.push_back({"NumPart_Total_HighWord", of_type(count >> low_bits)});
  attributes.push_back({"MassTable", of_type(masses ? 0.0 : 1.0)});
  attributes.push_back({"NumFilesPerSnapshot", std::vector<std::int64_t>{1}});
  const auto& length = source.tiles->period().length;
  const bool cube = length[0] == length[1] && (source.manifest.dimension == 2 || length[1] == length[2]);
  attributes.push_back(
      {"BoxSize", cube ? std::vector<double>{length[0]} : std::vector<double>(length.begin(), length.end())});
  for (const char* name : {"Time", "Redshift", "Omega0", "OmegaLambda"})
    attributes.push_back({name, std::vector<double>{0}});
  attributes.push_back({"HubbleParam", std::vector<double>{1}});
  return header;
}

// The tables of the file, and the part of a row for each.
struct SnapshotTables {
  Hdf5Layout layout;
  std::vector<Part> parts;
};

SnapshotTables snapshot_tables(const MeshSource& source, const PointTable& table) {
  SnapshotTables made;
  std::set<std::string> taken;
  const auto add = [&](std::string name, const TableColumn& column, std::vector<std::uint64_t> shape, Part part) {
    while (!taken.insert(name).second) name += '_';
    std::vector<Hdf5Attribute> attributes;
    if (!column.unit.empty()) attributes.push_back({"unit", column.unit});
    made.layout.tables.push_back(
        {.name = "PartType1/" + name, .shape = std::move(shape), .type = column.type, .attributes = attributes});
    made.parts.push_back(part);
  };
  const auto& columns = table.columns();
  const auto axes = static_cast<std::size_t>(source.manifest.dimension);
  const std::uint64_t rows = table.rows();
  constexpr std::size_t places = 3, place_bytes = places * sizeof(double);
  add("Coordinates", columns[1], {rows, places},
      {.offset = columns[1].offset, .bytes = axes * sizeof(double), .row_bytes = place_bytes, .numbers = places});
  bool masses = false;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::size_t bytes = size_of(columns[i].type);
    const Part part{.offset = columns[i].offset, .bytes = bytes, .row_bytes = bytes, .numbers = 1};
    if (i == 0) {
      add("ParticleIDs", columns[i], {rows}, part);
    } else if (i > axes) {
      const bool mass = columns[i].name == "mass";
      masses |= mass;
      add(mass ? "Masses" : columns[i].name, columns[i], {rows}, part);
    }
  }
  made.layout.attributes.push_back({"result", comment_of(stamp_of(source.manifest))});
  made.layout.groups.push_back(snapshot_header(source, rows, masses));
  return made;
}

}  // namespace

Result<Exported> write_hdf5(const MeshSource& source, const fs::path& path) {
  BOOST_OUTCOME_TRY(table, PointTable::open(source, source.options.names));
  const SnapshotTables tables = snapshot_tables(source, table);
  BOOST_OUTCOME_TRY(output, Hdf5Output::create(path, tables.layout));
  std::vector<std::byte> numbers;
  std::uint64_t first = 0;
  BOOST_OUTCOME_TRYV(table.for_each(folder_of(path), [&](std::span<const std::byte> rows) -> Status {
    const std::size_t count = rows.size() / table.row_bytes();
    for (std::size_t i = 0; i < tables.parts.size(); ++i) {
      const Part& part = tables.parts[i];
      numbers.assign(count * part.row_bytes, std::byte{0});
      for (std::size_t row = 0; row < count; ++row)
        std::copy_n(rows.data() + row * table.row_bytes() + part.offset, part.bytes,
                    numbers.data() + row * part.row_bytes);
      BOOST_OUTCOME_TRYV(output.write(i, first * part.numbers, numbers));
    }
    first += count;
    return success();
  }));
  BOOST_OUTCOME_TRY(bytes, output.commit());
  Exported exported;
  exported.vertices = table.rows();
  exported.files = 1;
  exported.bytes = bytes;
  return exported;
}

}  // namespace tessera::exports
