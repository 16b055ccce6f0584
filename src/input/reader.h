// An input file as a stream of batches. A reader never holds a whole file in memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/cosmology.h"

namespace tessera {

// Which columns are x, y and z, numbered from 1, and how they were found.
struct CoordinateColumns {
  enum class By : std::uint8_t { place, header, option };
  std::vector<std::size_t> numbers;
  By by = By::place;
};

// The snapshot of a simulation of which a file is a part.
struct SnapshotPart {
  std::string run;           // the same text in all files of the snapshot
  std::uint64_t files = 1;   // all files of the snapshot
  std::uint64_t points = 0;  // all particles of the snapshot
};

// The particles of one type in a snapshot.
struct ParticleKind {
  std::uint32_t type = 0;  // see snapshot/particle_types.h
  std::uint64_t count = 0;
  double mass = 0;  // of each particle, as the header says; 0: each has its own
};

// What a reader knows about a file after opening it.
struct FileInfo {
  std::filesystem::path path;
  std::string format;    // "las", "laz", "ply", "off", "obj", "stl", "e57", "ept", "pcd", "ptx", "pts", "xyz", "npy",
                         // "gadget", "tipsy", "hdf5", "fits"
  std::string detail;    // "LAS 1.4, point format 7", "binary little endian, float"
  int dimension = 3;     // 2 when the file has only x and y
  bool degrees = false;  // x and y are called longitude and latitude
  std::optional<std::uint64_t> points;       // the number of points that the reader gives, if the header tells it
  std::uint64_t points_passed_over = 0;      // the number of points that the reader skips because of its hints
  std::optional<Bounds> bounds;              // as the header says; they may be wrong
  Point step;                                // LAS: the scale; the header's bounds may be rounded to it; else 0
  std::string crs;                           // WKT, or "EPSG:n" from GeoTIFF keys; empty when unknown
  std::string crs_note;                      // why the system is unknown although the file says something about it
  std::vector<Attribute> attributes;         // all attributes that the file has
  std::optional<CoordinateColumns> columns;  // for text and NumPy
  bool counts_up = false;                // text: x was found by its place, and its values look like numbers of points
  std::uint64_t seek_points = 0;         // LAZ: how many points are decoded, on average, to reach a point
  std::uint64_t parts = 1;               // text: the number of parts in which it can be read; see ReadHints
  bool levels = false;                   // COPC, EPT: the points are sorted by level of detail
  std::optional<SnapshotPart> snapshot;  // Gadget
  std::vector<ParticleKind> particles;   // snapshots: all types of the file, those that are skipped included
  Point box;                             // the size of a periodic box, as the file says; 0: none
  std::string unit;                      // of the coordinates, as the file states it; "" when unknown
  // Snapshots: other numbers that the file states, by name, such as the redshift.
  std::vector<std::pair<std::string, double>> stated;
  bool redshifts = false;           // FITS: distances come from redshifts, by the cosmology of the hints
  std::string packing;              // "gzip" or "zstd" when the whole file is compressed
  std::uint64_t bytes = 0;          // size of the stored file
  std::uint64_t content_bytes = 0;  // size of the content: `bytes` unless the file is compressed
  std::int64_t modified_ns = 0;     // nanoseconds since 1970

  // The number of points, estimated by the size of the file where its header gives none.
  std::uint64_t about_points() const {
    constexpr std::uint64_t line_bytes = 32;  // of a usual line of text or ASCII PLY
    return points ? *points : content_bytes / line_bytes;
  }
};

// Points in the order of the file. Readers pass on coordinates that are not finite; the caller drops or refuses them.
struct PointBatch {
  std::vector<Point> points;
  std::vector<std::byte> rows;  // points.size() rows of the schema that was asked for; see attribute.h
  // The points that the reader skipped since the last batch because of its hints. Only readers that skip points set
  // this.
  std::uint64_t passed_over = 0;
};

// Reads the points of one file. Not thread-safe.
class PointReader {
 public:
  virtual ~PointReader() = default;
  virtual const FileInfo& info() const = 0;
  // Replaces `batch` by the next points, about 64 Ki and at most `most`. An empty batch is the end of the file. Errors
  // name the file, the record or line, and the reason.
  virtual Status next(PointBatch& batch, std::size_t most) = 0;
  Status next(PointBatch& batch) { return next(batch, SIZE_MAX); }
  // Makes point `index` the next point, so that a sample need not read everything. Returns false if the format cannot
  // seek (text).
  virtual Result<bool> seek(std::uint64_t index) = 0;
  // Where in the file point `index` of the last batch is, for error messages: "record 17" or "line 812". Records count
  // from 0, as ids do; lines count from 1, as in editors.
  virtual std::string place(std::size_t index) const = 0;
};

// Hints that let a reader read less or faster. The caller must still filter what the reader gives.
struct ReadHints {
  std::optional<Box> crop = {};           // a closed box; the reader may skip points outside
  std::vector<std::uint32_t> scans = {};  // E57: the reader may skip other scans; empty: read all
  std::vector<std::uint32_t> particles =
      {};                 // snapshots: the reader may skip particles of other types; empty: read all
  double resolution = 0;  // COPC, EPT: read octree levels up to the first whose spacing is at most this; 0: read all
  std::uint32_t threads = 1;  // how many threads may decompress at once
  // Read only this part of the FileInfo::parts. All parts in order give the points of the whole file. Lines in errors
  // and in place() count from the beginning of the part, or with `count_lines`, which takes some time, from the
  // beginning of the file.
  std::optional<std::uint64_t> part = {};
  bool count_lines = false;
  // Text, NumPy: the names of the columns in order, whatever the file says; FITS: which columns are coordinates
  // (column_names.h). Empty: as the file says.
  std::vector<std::string> columns = {};
  std::string hdu = {};                     // FITS: the number or name of the table's HDU; "": the first table
  std::optional<Cosmology> cosmology = {};  // FITS: what turns redshifts into distances
};

// Opens a file that is not compressed (see Spool), by its content, then by its name. `attributes` is the schema of the
// rows. An attribute that the file lacks is zero. An attribute of another type is converted.
Result<std::unique_ptr<PointReader>> open_reader(const std::filesystem::path& path,
                                                 const std::vector<Attribute>& attributes = {},
                                                 const ReadHints& hints = {});

class ByteSource;
// The FileInfo of a source, as far as the source knows it.
FileInfo info_of(const ByteSource& source, std::string format);

// The same for a source that is already open.
Result<std::unique_ptr<PointReader>> open_reader(std::unique_ptr<ByteSource> source,
                                                 const std::vector<Attribute>& attributes = {},
                                                 const ReadHints& hints = {});

}  // namespace tessera
