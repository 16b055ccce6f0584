// The filters of a cloud: refuse or drop points that are not finite, keep a box and some classes, drop z in 2D, and
// move what is left into the box of a periodic cloud.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/periodic_box.h"
#include "src/input/cloud/cloud.h"
#include "src/input/reader.h"

namespace tessera {

// The attributes by which the options filter, with the keys of these options.
std::vector<std::pair<std::string, const char*>> filtered_by(const CloudOptions& options);

// Filters points. Const functions are thread-safe.
class PointFilter {
 public:
  // `schema` is the schema of the cloud.
  PointFilter(const CloudOptions& options, const std::vector<Attribute>& schema);

  // The schema that the file's reader must give: the cloud's schema, then the other attributes by which the options
  // filter.
  const std::vector<Attribute>& reader_schema() const { return reader_schema_; }

  // Appends the kept points of `batch` to `to` and adds to `counts`. Points get the ids first_id, first_id + 1, ...,
  // and dropped points use up ids, too. Error bad_input at a point that is not finite, unless such points are skipped;
  // and at a point that cannot be moved into the periodic box.
  Status apply(const PointBatch& batch, const PointReader& reader, std::uint64_t first_id, CloudBatch& to,
               CloudCounts& counts) const;

 private:
  // Moves a point into the periodic box. Returns why it cannot be moved, as the end of a sentence; "" when it was.
  std::string move(Point& p, CloudCounts& counts) const;
  bool is_valid(const Point& p) const;
  bool is_in_box(const Point& p) const;
  bool is_wanted(const std::byte* row, CloudCounts& counts) const;
  // An attribute in the reader's row.
  struct Column {
    std::size_t at = 0;
    AttributeType type = AttributeType::u8;
    double value(const std::byte* row) const;
  };
  // `type`: of the column that the reader adds when the cloud's schema does not have it.
  Column column(const std::string& name, AttributeType type);

  CloudOptions options_;
  std::vector<Attribute> reader_schema_;
  std::size_t row_bytes_, reader_row_bytes_;
  std::optional<std::size_t> z_at_;  // where z is in a row of the cloud
  Column class_, number_, of_;       // classification, number of the return, number of returns of the pulse
  Column scan_, particle_type_;
  std::vector<Column> flags_;
  PeriodicBox box_;
};

}  // namespace tessera
