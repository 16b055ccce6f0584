// What a cloud does to a file's points: refuse or drop the non-finite, keep a box and classes, drop z in 2D.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/input/cloud/cloud.h"
#include "src/input/reader.h"

namespace tessera {

// The attributes that the options filter by, and the keys of these options.
std::vector<std::pair<std::string, const char*>> filtered_by(const CloudOptions& options);

class PointFilter {
 public:
  // `schema` is the cloud's.
  PointFilter(const CloudOptions& options, const std::vector<Attribute>& schema);

  // What the file's reader must give: the schema, and behind it what else the options filter by.
  const std::vector<Attribute>& reader_schema() const { return reader_schema_; }

  // Appends the points of `batch` that are kept to `to`, with ids first_id, first_id + 1, ... given to kept and dropped
  // ones alike, and adds to `counts`. Error bad_input at a non-finite point, unless they are to be skipped.
  Status apply(const PointBatch& batch, const PointReader& reader, std::uint64_t first_id, CloudBatch& to,
               CloudCounts& counts) const;

 private:
  bool is_valid(const Point& p) const;
  bool is_in_box(const Point& p) const;
  bool is_wanted(const std::byte* row, CloudCounts& counts) const;
  // Of an attribute of the reader's row.
  struct Column {
    std::size_t at = 0;
    AttributeType type = AttributeType::u8;
    double value(const std::byte* row) const;
  };
  Column column(const std::string& name);

  CloudOptions options_;
  std::vector<Attribute> reader_schema_;
  std::size_t row_bytes_, reader_row_bytes_;
  std::optional<std::size_t> z_at_;  // where a row of the cloud carries z
  Column class_, number_, of_;       // classification, number of the return, returns of the pulse
  std::vector<Column> flags_;
};

}  // namespace tessera
