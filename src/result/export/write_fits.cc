// A FITS binary table of the points, in the order of the input. Source of the format: the FITS standard 4.0, sections 4
// and 7.3 (https://fits.gsfc.nasa.gov/fits_standard.html).
#include <algorithm>
#include <string>
#include <vector>

#include "src/base/files/fits_cards.h"
#include "src/base/image.h"
#include "src/base/option.h"
#include "src/result/export/formats.h"
#include "src/result/export/output.h"
#include "src/result/export/point_table.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t most_columns = 999;

// How FITS holds a type: tables have no unsigned integers of more than 8 bits, and no signed ones of 8. Such values
// have another sign bit and say so in TZERO.
struct FitsType {
  char code;
  const char* zero = nullptr;
};

FitsType fits_type(AttributeType type) {
  constexpr FitsType types[] = {
      {'B'}, {'B', "-128"}, {'I', "32768"}, {'I'}, {'J', "2147483648"}, {'J'}, {'K', "9223372036854775808"},
      {'K'}, {'E'},         {'D'}};
  return types[static_cast<int>(type)];
}

std::string primary_header() {
  FitsCards cards;
  cards.flag("SIMPLE", true);
  cards.whole("BITPIX", 8);
  cards.whole("NAXIS", 0);
  cards.flag("EXTEND", true);
  return cards.end();
}

std::string table_header(const MeshSource& source, const PointTable& table) {
  FitsCards cards;
  cards.text("XTENSION", "BINTABLE");
  cards.whole("BITPIX", 8);
  cards.whole("NAXIS", 2);
  cards.whole("NAXIS1", table.row_bytes());
  cards.whole("NAXIS2", table.rows());
  cards.whole("PCOUNT", 0);
  cards.whole("GCOUNT", 1);
  cards.whole("TFIELDS", table.columns().size());
  cards.text("EXTNAME", "POINTS");
  const Period& period = source.tiles->period();
  for (int axis = 0; axis < 3; ++axis)
    if (period.along(axis))
      cards.real("PERIOD" + std::to_string(axis + 1), period.length[static_cast<std::size_t>(axis)]);
  for (std::size_t i = 0; i < table.columns().size(); ++i) {
    const TableColumn& column = table.columns()[i];
    const std::string number = std::to_string(i + 1);
    const FitsType type = fits_type(column.type);
    cards.text("TTYPE" + number, column.name);
    cards.text("TFORM" + number, std::string("1") + type.code);
    if (type.zero != nullptr) {
      cards.add("TSCAL" + number, "1");
      cards.add("TZERO" + number, type.zero);
    }
    if (!column.unit.empty()) cards.text("TUNIT" + number, column.unit);
  }
  cards.comment(comment_of(stamp_of(source.manifest)));
  return cards.end();
}

// Makes a row one of FITS: big endian, with the other sign bit where the type needs it.
void turn_row(const std::vector<TableColumn>& columns, std::span<std::byte> row) {
  for (const auto& column : columns) {
    const auto value = row.subspan(column.offset, size_of(column.type));
    std::reverse(value.begin(), value.end());
    if (fits_type(column.type).zero != nullptr) value[0] ^= std::byte{0x80};
  }
}

}  // namespace

Result<Exported> write_fits(const MeshSource& source, const fs::path& path) {
  BOOST_OUTCOME_TRY(table, PointTable::open(source, source.options.names));
  if (table.columns().size() > most_columns)
    return error(Errc::usage, source.out.string() + ": the table would have " + std::to_string(table.columns().size()) +
                                  " columns, and FITS tables have at most " + std::to_string(most_columns) + "; " +
                                  option("names") + " chooses some");
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  Stream stream(file, 0);
  stream.text(primary_header() + table_header(source, table));
  const std::size_t stride = table.row_bytes();
  std::vector<std::byte> turned;
  BOOST_OUTCOME_TRYV(table.for_each(folder_of(path), [&](std::span<const std::byte> rows) {
    turned.assign(rows.begin(), rows.end());
    for (std::size_t at = 0; at < turned.size(); at += stride)
      turn_row(table.columns(), std::span(turned).subspan(at, stride));
    stream.bytes(turned);
    return stream.status();
  }));
  stream.bytes(std::vector<std::byte>(fits_blocks_of(stream.offset()) - stream.offset()));
  BOOST_OUTCOME_TRYV(stream.flush());
  BOOST_OUTCOME_TRY(bytes, file.finish());
  Exported exported;
  exported.vertices = table.rows();
  exported.files = 1;
  exported.bytes = bytes;
  return exported;
}

}  // namespace tessera::exports
