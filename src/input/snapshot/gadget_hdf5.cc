#include "src/input/snapshot/gadget_hdf5.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/snapshot/hdf5_file.h"
#include "src/input/snapshot/hdf5_units.h"
#include "src/input/snapshot/particle_types.h"

namespace tessera::snapshot {
namespace {

std::atomic<bool> hdf5_is_refused = false;

// The names that an attribute has whatever wrote the file.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> usual_names{
    {{"Velocities", "v"}, {"ParticleIDs", "particle_id"}, {"Masses", "mass"}}};

struct SnapshotHeader {
  std::vector<std::uint64_t> particles;
  std::vector<double> mass, box;
  SnapshotPart part;
};

// A column of an attribute: a number of each row of a table.
struct TableColumn {
  std::size_t table = 0, column = 0, attribute = 0;
};

struct ParticleType {
  std::size_t number = 0;
  std::uint64_t first = 0, count = 0;
  std::vector<Dataset> tables = {};
  std::size_t positions = 0;     // which table
  bool whole_positions = false;  // positions are integers
  std::vector<TableColumn> columns = {};
  std::string group() const { return "/PartType" + std::to_string(number); }
};

struct Snapshot {
  std::vector<ParticleType> types;
  std::vector<Attribute> attributes{{"particle_type", AttributeType::u8}};
  std::vector<double> mass;  // by type; 0: each particle has its own
  std::array<double, 3> box{};
  std::uint64_t particles = 0;  // of the file
  KeptParticles kept;
  std::string unit;  // of positions
};

Result<SnapshotHeader> read_header(const Hdf5File& file, const std::string& path) {
  const auto bad = [&](const std::string& what) { return error(Errc::bad_input, path + ": " + what); };
  SnapshotHeader header;
  auto particles = file.counts("/Header", "NumPart_ThisFile");
  if (!particles) return bad("is HDF5, but no snapshot: it has no group Header with the attribute NumPart_ThisFile");
  header.particles = std::move(*particles);
  if (header.particles.size() > types_max)
    return bad("has " + std::to_string(header.particles.size()) + " types of particles; at most " +
               std::to_string(types_max) + " are read");
  header.mass = file.numbers("/Header", "MassTable").value_or(std::vector<double>{});
  header.mass.resize(header.particles.size());
  header.box = file.numbers("/Header", "BoxSize").value_or(std::vector<double>{0});
  if (header.box.size() == 1) header.box.resize(3, header.box[0]);
  if (header.box.size() != 3 ||
      !std::all_of(header.box.begin(), header.box.end(), [](double size) { return std::isfinite(size) && size >= 0; }))
    return bad("says that its box is " + json_text(nlohmann::json(header.box)) +
               ", which are not one or three lengths");
  auto total = file.counts("/Header", "NumPart_Total").value_or(header.particles);
  const auto high = file.counts("/Header", "NumPart_Total_HighWord");
  for (std::size_t t = 0; high && t < std::min(total.size(), high->size()); ++t) total[t] += (*high)[t] << 32;
  const auto files = file.counts("/Header", "NumFilesPerSnapshot");
  const auto time = file.numbers("/Header", "Time");
  header.part = SnapshotPart{.run = json_text(nlohmann::json{{"time", time.value_or(std::vector<double>{})},
                                                             {"box", header.box},
                                                             {"total", total},
                                                             {"mass", header.mass}}),
                             .files = files && files->size() == 1 ? std::max<std::uint64_t>(1, (*files)[0]) : 1,
                             .points = std::accumulate(total.begin(), total.end(), std::uint64_t{0})};
  return header;
}

std::vector<std::string> names_of(const Dataset& table) {
  std::string name = table.name;
  for (const auto& [stored, usual] : usual_names)
    if (table.name == stored) name = usual;
  if (table.columns == 1) return {name};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.columns; ++i) {
    if (name == "v" && table.columns == 3) {
      names.push_back(std::string("v") + "xyz"[i]);
    } else {
      names.push_back(name + "_" + std::to_string(i + 1));
    }
  }
  return names;
}

// Adds the tables of a type. Attributes of the same name in several types become one; doubles if their types differ.
class Tables {
 public:
  Tables(Snapshot& snapshot, const Hdf5File& file, std::string path)
      : snapshot_(snapshot), file_(file), path_(std::move(path)) {}

  Status add(ParticleType& type) {
    std::optional<std::size_t> positions;
    for (std::size_t t = 0; t < type.tables.size(); ++t) {
      const Dataset& table = type.tables[t];
      const bool whole = table.name == "IntegerCoordinates";
      if (table.name == "Coordinates" || (whole && !positions)) {
        BOOST_OUTCOME_TRYV(check_positions(type, table, whole));
        positions = t;
        type.whole_positions = whole;
      } else if (!whole && table.rows == type.count) {
        const auto names = names_of(table);
        const std::string unit = unit_of_table(file_, type.group(), table.name);
        for (std::size_t c = 0; c < names.size(); ++c)
          type.columns.push_back({t, c, attribute(names[c], table.type, unit)});
      }
    }
    if (!positions) return bad(type, "has neither Coordinates nor IntegerCoordinates");
    type.positions = *positions;
    const std::string unit = unit_of_table(file_, type.group(), type.tables[*positions].name);
    snapshot_.unit = snapshot_.types.empty() || snapshot_.unit == unit ? unit : "";
    return success();
  }

 private:
  Error bad(const ParticleType& type, const std::string& what) const {
    return error(Errc::bad_input, path_ + ": its group " + type.group() + " " + what);
  }

  Status check_positions(const ParticleType& type, const Dataset& table, bool whole) const {
    if (table.columns != 3 || table.rows != type.count)
      return bad(type, "has " + std::to_string(table.rows) + " x " + std::to_string(table.columns) + " " + table.name +
                           ", but the header says " + std::to_string(type.count) + " particles");
    if (!whole) return success();
    if (table.type != AttributeType::u32 && table.type != AttributeType::u64 && table.type != AttributeType::i32 &&
        table.type != AttributeType::i64)
      return bad(type, "has IntegerCoordinates that are not integers of 32 or 64 bits");
    if (std::any_of(snapshot_.box.begin(), snapshot_.box.end(), [](double size) { return size == 0; }))
      return bad(type, "has IntegerCoordinates, but the header has no BoxSize to scale them");
    return success();
  }

  std::size_t attribute(const std::string& raw, AttributeType type, const std::string& unit) {
    for (std::size_t i = 0; i < raw_.size(); ++i) {
      if (raw_[i] != raw) continue;
      Attribute& known = snapshot_.attributes[i + 1];
      if (known.type != type) known.type = AttributeType::f64;
      if (known.unit != unit) known.unit.clear();
      return i + 1;
    }
    raw_.push_back(raw);
    snapshot_.attributes.push_back({names_.make(raw), type, unit});
    return raw_.size();
  }

  Snapshot& snapshot_;
  const Hdf5File& file_;
  std::string path_;
  AttributeNames names_;
  std::vector<std::string> raw_;  // of attributes 1, 2, ...
};

// `wanted`: the types to read; empty: all.
Result<Snapshot> read_snapshot(const Hdf5File& file, const SnapshotHeader& header,
                               std::span<const std::uint32_t> wanted, const std::string& path) {
  Snapshot snapshot;
  snapshot.mass = header.mass;
  std::copy(header.box.begin(), header.box.end(), snapshot.box.begin());
  Tables tables(snapshot, file, path);
  for (std::size_t t = 0; t < header.particles.size(); ++t) {
    if (header.particles[t] == 0) continue;
    ParticleType type{.number = t, .first = snapshot.particles, .count = header.particles[t]};
    if (type.count > UINT64_MAX - snapshot.particles) return error(Errc::bad_input, path + ": has too many particles");
    snapshot.particles += type.count;
    const bool kept = is_wanted(wanted, static_cast<std::uint32_t>(t));
    snapshot.kept.add(type.count, kept);
    if (!kept) continue;
    if (!file.has_group(type.group()))
      return error(Errc::bad_input, path + ": says that it has " + std::to_string(type.count) + " particles of type " +
                                        std::to_string(t) + ", but has no group " + type.group());
    BOOST_OUTCOME_TRY(found, file.datasets(type.group()));
    type.tables = std::move(found);
    BOOST_OUTCOME_TRYV(tables.add(type));
    snapshot.types.push_back(std::move(type));
  }
  // A file of several may have none.
  if (snapshot.particles == 0 && header.part.files < 2) return error(Errc::bad_input, path + ": holds no particles");
  const auto own = std::find_if(snapshot.attributes.begin(), snapshot.attributes.end(),
                                [](const Attribute& a) { return a.name == "mass"; });
  const bool shared = std::any_of(header.mass.begin(), header.mass.end(), [](double mass) { return mass != 0; });
  if (own == snapshot.attributes.end() && shared) snapshot.attributes.push_back({"mass", AttributeType::f64});
  return snapshot;
}

class Hdf5Reader : public PointReader {
 public:
  Hdf5Reader(FileInfo info, std::unique_ptr<ByteSource> source, Hdf5File file, Snapshot snapshot,
             const std::vector<Attribute>& schema)
      : info_(std::move(info)),
        source_(std::move(source)),
        file_(std::move(file)),
        snapshot_(std::move(snapshot)),
        row_bytes_(row_bytes(schema)) {
    const auto offsets = row_offsets(schema);
    for (std::size_t i = 0; i < schema.size(); ++i)
      for (std::size_t a = 0; a < snapshot_.attributes.size(); ++a)
        if (snapshot_.attributes[a].name == schema[i].name) wanted_.push_back({a, offsets[i], schema[i].type});
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    const std::uint64_t at = snapshot_.kept.from(position_).begin;
    batch.passed_over = at - position_;
    first_ = position_ = at;
    const auto type = std::find_if(snapshot_.types.begin(), snapshot_.types.end(),
                                   [&](const ParticleType& t) { return position_ < t.first + t.count; });
    batch.points.clear();
    batch.rows.clear();
    if (type == snapshot_.types.end()) return source_->check_unchanged();
    const std::uint64_t row = position_ - type->first;
    const auto n =
        static_cast<std::size_t>(std::min<std::uint64_t>(points_at_once(most, row_bytes_), type->count - row));
    BOOST_OUTCOME_TRYV(read_positions(*type, row, n, batch));
    BOOST_OUTCOME_TRYV(read_rows(*type, row, n, batch));
    position_ += n;
    return success();
  }

  Result<bool> seek(std::uint64_t index) override {
    position_ = snapshot_.kept.particle_of(index);
    return true;
  }

  std::string place(std::size_t index) const override { return "particle " + std::to_string(first_ + index); }

 private:
  struct Wanted {
    std::size_t attribute, offset;
    AttributeType type;
  };

  Status read_table(const ParticleType& type, std::size_t table, std::uint64_t row, std::size_t n) {
    const Dataset& dataset = type.tables[table];
    block_.resize(n * dataset.columns * size_of(dataset.type));
    return file_.read(type.group(), dataset, row, n, block_);
  }

  Status read_positions(const ParticleType& type, std::uint64_t row, std::size_t n, PointBatch& batch) {
    batch.points.resize(n);
    BOOST_OUTCOME_TRYV(read_table(type, type.positions, row, n));
    AttributeType stored = type.tables[type.positions].type;
    const std::size_t size = size_of(stored);
    // Integers count steps of the box from 0, whatever sign the file gives them.
    if (type.whole_positions) stored = size == 4 ? AttributeType::u32 : AttributeType::u64;
    auto* to = reinterpret_cast<std::byte*>(batch.points.data());
    for (std::size_t axis = 0; axis < 3; ++axis)
      column_copy(stored, false, AttributeType::f64)(block_.data() + axis * size, 3 * size, to + axis * sizeof(double),
                                                     sizeof(Point), n);
    if (!type.whole_positions) return success();
    const int bits = static_cast<int>(8 * size);
    for (Point& p : batch.points)
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = std::ldexp(p[axis], -bits) * snapshot_.box[static_cast<std::size_t>(axis)];
    return success();
  }

  Status read_rows(const ParticleType& type, std::uint64_t row, std::size_t n, PointBatch& batch) {
    batch.rows.resize(n * row_bytes_);
    const auto fill = [&](const Wanted& wanted, double value) {
      column_copy(AttributeType::f64, false, wanted.type)(reinterpret_cast<const std::byte*>(&value), 0,
                                                          batch.rows.data() + wanted.offset, row_bytes_, n);
    };
    for (const Wanted& wanted : wanted_) {
      const std::string& name = snapshot_.attributes[wanted.attribute].name;
      const double mass = snapshot_.mass[type.number];
      fill(wanted, wanted.attribute == 0         ? static_cast<double>(type.number)
                   : name == "mass" && mass != 0 ? mass
                                                 : std::numeric_limits<double>::quiet_NaN());
    }
    std::optional<std::size_t> loaded;
    for (const TableColumn& column : type.columns)
      for (const Wanted& wanted : wanted_) {
        if (wanted.attribute != column.attribute) continue;
        if (loaded != column.table) {
          BOOST_OUTCOME_TRYV(read_table(type, column.table, row, n));
          loaded = column.table;
        }
        const Dataset& table = type.tables[column.table];
        const std::size_t size = size_of(table.type);
        column_copy(table.type, false, wanted.type)(block_.data() + column.column * size, table.columns * size,
                                                    batch.rows.data() + wanted.offset, row_bytes_, n);
      }
    return success();
  }

  FileInfo info_;
  std::unique_ptr<ByteSource> source_;  // outlives file_
  Hdf5File file_;
  Snapshot snapshot_;
  std::size_t row_bytes_;
  std::vector<Wanted> wanted_;
  std::uint64_t position_ = 0, first_ = 0;
  std::vector<std::byte> block_;
};

}  // namespace

void refuse_hdf5() { hdf5_is_refused = true; }

bool looks_like_hdf5(std::span<const std::byte> begin) {
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  return begin.size() >= signature.size() &&
         std::string_view(reinterpret_cast<const char*>(begin.data()), signature.size()) == signature;
}

Result<std::unique_ptr<PointReader>> open_gadget_hdf5(std::unique_ptr<ByteSource> source,
                                                      const std::vector<Attribute>& attributes,
                                                      const ReadHints& hints) {
  FileInfo info = info_of(*source, "hdf5");
  const std::string path = info.path.string();
  if (hdf5_is_refused)
    return error(Errc::bad_input, path +
                                      ": HDF5 is not read here, because its library was not made for files of "
                                      "strangers; the daemon's operator can allow it with the daemon's option hdf5");
  BOOST_OUTCOME_TRY(file, Hdf5File::open(*source));
  BOOST_OUTCOME_TRY(header, read_header(file, path));
  BOOST_OUTCOME_TRY(snapshot, read_snapshot(file, header, hints.particles, path));
  info.detail = "a snapshot in HDF5";
  info.points = snapshot.kept.points();
  info.points_passed_over = snapshot.kept.passed_over();
  for (std::size_t t = 0; t < header.particles.size(); ++t)
    if (header.particles[t] > 0)
      info.particles.push_back(
          {.type = static_cast<std::uint32_t>(t), .count = header.particles[t], .mass = header.mass[t]});
  info.stated = stated_numbers(file);
  info.unit = snapshot.unit;
  info.attributes = snapshot.attributes;
  info.snapshot = header.part;
  info.box = {snapshot.box[0], snapshot.box[1], snapshot.box[2]};
  return std::unique_ptr<PointReader>(
      new Hdf5Reader(std::move(info), std::move(source), std::move(file), std::move(snapshot), attributes));
}

}  // namespace tessera::snapshot
