// The units of files: a node of COPC or EPT with its cube is a unit, and a whole file of another format is one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/input/cloud/point_filter.h"
#include "src/input/cloud/point_units.h"

namespace tessera {

// The units of a cloud. Not thread-safe.
class CloudUnits : public PointUnits {
 public:
  // Opens the units of a cloud. Their bounds are what the files state: for COPC and EPT the node's cube within the
  // header's box, for LAS and LAZ the header's box. They are widened by what rounding to the file's steps may cost.
  // Files that state no bounds, and with `scan` all files, are read once to their end. Errors: those of reading;
  // interrupted. REQUIRES: the cloud is not cropped.
  static Result<std::unique_ptr<CloudUnits>> open(Cloud cloud, bool scan, const std::stop_token& stop = {});

  const Cloud& cloud() const { return cloud_; }
  std::uint64_t points() const { return points_; }  // of the whole cloud, including filtered points
  const std::vector<PointUnit>& list() const override { return list_; }
  Status read(std::span<const std::size_t> units,
              const std::function<Status(std::size_t, CloudBatch&)>& visit) override;
  std::string name(std::size_t unit) const override;
  std::uint64_t bytes_read() const override { return bytes_read_; }

 private:
  // The records of a unit.
  struct RecordRange {
    std::size_t file = 0;
    std::uint64_t first = 0;  // the first record of the unit in the file
    std::uint64_t begin = 0;  // COPC: the first byte of the unit in the file
    bool whole = false;       // the unit is the whole file, however many records it has
    bool seen = false;        // the bounds come from reading the points, not from the file
  };

  explicit CloudUnits(Cloud cloud);
  Status add_file(std::size_t file, bool scan, const std::stop_token& stop);
  Status scan_file(std::size_t file, std::size_t begin, const std::stop_token& stop);
  std::size_t units_ahead(std::span<const std::size_t> units, std::size_t begin) const;
  Status bring(std::span<const std::size_t> units) const;
  Status read_unit(PointReader& reader, std::size_t unit, const std::function<Status(std::size_t, CloudBatch&)>& visit);
  Status check_inside(const std::vector<LocalPoint>& points, std::size_t unit) const;

  Cloud cloud_;
  PointFilter filter_;
  std::vector<PointUnit> list_;
  std::vector<RecordRange> ranges_;
  std::vector<std::uint64_t> first_ids_;  // the source index of the first point, by file
  std::uint64_t points_ = 0, bytes_read_ = 0;
};

}  // namespace tessera
