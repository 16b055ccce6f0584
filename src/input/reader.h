// One input file as a stream of batches. A reader never holds a file in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

// Which columns are x, y and z, from 1 on, and what said so.
struct CoordinateColumns {
  enum class By : std::uint8_t { place, header, option };
  std::vector<std::size_t> numbers;
  By by = By::place;
};

struct FileInfo {
  std::filesystem::path path;
  std::string format;                        // "las", "laz", "ply", "off", "obj", "stl", "xyz", "npy"
  std::string detail;                        // "LAS 1.4, point format 7", "binary little endian, float"
  int dimension = 3;                         // 2 when the file holds x and y alone
  bool degrees = false;                      // x and y are longitude and latitude, by their names
  std::optional<std::uint64_t> points;       // that the reader gives, when the header says
  std::uint64_t points_passed_over = 0;      // that it does not give, because of its hints
  std::optional<Bounds> bounds;              // when the header says; not to be trusted
  Point step;                                // LAS: the scale, to which the header's bounds may be rounded; else 0
  std::string crs;                           // WKT, or "EPSG:n" from GeoTIFF keys; empty when unknown
  std::string crs_note;                      // why it is unknown although the file says something
  std::vector<Attribute> attributes;         // what the file could give
  std::optional<CoordinateColumns> columns;  // text, NumPy
  bool counts_up = false;                    // text: x was found by its place, and looks like numbers of points
  std::uint64_t seek_points = 0;             // LAZ: points that are decoded, on average, to get to the one sought
  std::uint64_t parts = 1;                   // text: the parts in which it can be read, see ReadHints
  bool levels = false;                       // COPC: the points are sorted into levels of detail
  std::string packing;                       // "gzip" or "zstd" when the file is compressed as a whole
  std::uint64_t bytes = 0;                   // of the file as it is
  std::uint64_t content_bytes = 0;           // of what is in it: `bytes` unless it is compressed
  std::int64_t modified_ns = 0;              // since 1970
};

// Points in file order. Non-finite coordinates are passed on: the caller rejects or refuses them.
struct PointBatch {
  std::vector<Point> points;
  std::vector<std::byte> rows;  // points.size() rows of the schema asked for; see attribute.h
  // Points of the file passed over since the last batch, because of the hints. Only readers that do so set it.
  std::uint64_t passed_over = 0;
};

class PointReader {
 public:
  virtual ~PointReader() = default;
  virtual const FileInfo& info() const = 0;
  // Replaces `batch` by the next points (about 64 Ki, at most `most`); an empty batch is the end of the file.
  // Errors name the file, the record or line, and the reason.
  virtual Status next(PointBatch& batch, std::size_t most) = 0;
  Status next(PointBatch& batch) { return next(batch, SIZE_MAX); }
  // Goes to point `index`, so that a sample need not read everything. False if this format cannot (text).
  virtual Result<bool> seek(std::uint64_t index) = 0;
  // "record 17" or "line 812": where in the file point `index` of the last batch stands, for error messages. Records
  // count from 0, as ids do; lines from 1, as editors do.
  virtual std::string place(std::size_t index) const = 0;
};

// What a reader may make use of to read less or faster; what it gives has to be filtered all the same.
struct ReadHints {
  std::optional<Box> crop = {};  // closed box: points outside may be passed over
  double resolution = 0;         // COPC: read no finer octree level than one whose points are this far apart; 0: all
  std::uint32_t threads = 1;     // that may decompress at once
  // Read this part alone, of those that FileInfo tells of; one after the other they give what the whole gives. Lines
  // that errors and place() name are counted from the begin of the part, or with `count_lines`, which takes its time,
  // of the file.
  std::optional<std::uint64_t> part = {};
  bool count_lines = false;
  // Text, NumPy: what the columns are called, in their order, whatever the file says (column_names.h); empty: what it
  // says.
  std::vector<std::string> columns = {};
};

// Opens `path`, which is not compressed (see Spool), by its content, then by its name. `attributes`: the schema of
// batch rows; an attribute that this file lacks is zero, one of another type is converted.
Result<std::unique_ptr<PointReader>> open_reader(const std::filesystem::path& path,
                                                 const std::vector<Attribute>& attributes = {},
                                                 const ReadHints& hints = {});

class ByteSource;
// What a source says of itself.
FileInfo info_of(const ByteSource& source, std::string format);

// The same for bytes that are open already.
Result<std::unique_ptr<PointReader>> open_reader(std::unique_ptr<ByteSource> source,
                                                 const std::vector<Attribute>& attributes = {},
                                                 const ReadHints& hints = {});

}  // namespace tessera
