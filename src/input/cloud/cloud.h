// Several files as one cloud, with the filters of the user.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/image.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Which returns (echoes) of each pulse of the scanner are kept.
enum class Returns : std::uint8_t { all, first, last, single };

struct CloudOptions {
  // 2: x and y are triangulated and z becomes 0. 0: 3, or 2 if all files have only x and y.
  int dimension = 3;
  DuplicatePolicy keep = DuplicatePolicy::first;  // 2D: which of the points with equal x and y is kept
  bool heights = true;                            // 2D: carry z as the attribute "z", if a file has it
  bool skip_invalid = false;     // drop points that are not finite, and count them, instead of refusing the file
  std::optional<Box> crop = {};  // a closed box; points outside do not belong to the cloud
  // The periods of a periodic cloud: one for all axes, or one for each axis, 0 for none. Points are moved into the box
  // from 0 to the periods, after all filters. Empty: the cloud has no period.
  std::vector<double> periodic = {};
  bool periodic_files = false;    // the periods are the sides of the box that the files state, in place of `periodic`
  bool snap = true;               // round coordinates and periods whose shifts would round, instead of refusing them
  Period period = {};             // follows from `periodic`; see settle_period()
  std::vector<int> classes = {};  // keep only these LAS classes; empty: keep all
  std::vector<std::uint32_t> scans = {};  // keep only points of these scans, the attribute "scan"; empty: keep all
  // Keep only particles of these types, the attribute "particle_type" (snapshot/particle_types.h); empty: keep all.
  std::vector<std::uint32_t> particles = {};
  Returns returns = Returns::all;            // keep only these echoes of each pulse
  std::vector<std::string> without = {};     // drop points with one of these flags: "withheld", "synthetic", ...
  std::vector<std::string> attributes = {};  // the names of attributes to carry, or {"all"}
  std::vector<std::string> columns = {};     // text, NumPy, FITS: the names of the columns; see ReadHints
  std::string hdu = {};                      // FITS: the table; see ReadHints
  std::optional<Cosmology> cosmology = {};   // FITS: what turns redshifts into distances
  double resolution = 0;                     // COPC, EPT: the distance between points that is enough; 0: keep all
  std::uint32_t threads = 1;                 // how many threads may open, read and unpack files at once
  std::string crs = {};         // WKT or "EPSG:n" of all files, whatever the files say; empty: as the files say
  std::string input_list = {};  // a file that names more inputs; see InputQuestion
  bool recursive = false;       // read folders with their subfolders
  // The folder in which standard input and unpacked files wait, as files without names. Empty: the system's temporary
  // folder.
  std::filesystem::path spool_folder = {};
  std::uint64_t spool_bytes_max = 0;  // the most bytes that may wait there; 0: no bound but the disk
};

// The flags of points in LAS, by the names of their attributes.
inline constexpr std::array<std::string_view, 4> point_flags{"withheld", "synthetic", "overlap", "key_point"};

// Points with their source indices, and their rows. Filtered and rejected points count in source indices, too.
struct CloudBatch {
  std::vector<LocalPoint> points;
  std::vector<std::byte> rows;
};

// How many points were read and dropped.
struct CloudCounts {
  std::uint64_t read = 0;     // points in the files
  std::uint64_t invalid = 0;  // points that are not finite and were dropped by --skip-invalid
  // Points outside the crop box, of a class, return or flag that was not wanted, or of a level finer than the
  // resolution.
  std::uint64_t filtered = 0;
  // For points that were filtered one by one: the bounds of those outside the crop box, and the classes of those of
  // other classes.
  Bounds outside = {};
  std::bitset<256> other_classes = {};
  // Of a periodic cloud: how many points were moved by whole periods, the greatest change of a coordinate by rounding,
  // and the bounds of the points before.
  std::uint64_t moved = 0;
  double snapped = 0;
  Bounds unmoved = {};

  void add(const CloudCounts& more) {
    read += more.read;
    invalid += more.invalid;
    filtered += more.filtered;
    outside.add(more.outside);
    other_classes |= more.other_classes;
    moved += more.moved;
    snapped = std::max(snapped, more.snapped);
    unmoved.add(more.unmoved);
  }
};

// A part of the input that can be read by itself.
struct InputSplit {
  // A whole file; or points begin..begin+count-1 of a file that can be entered in the middle; or these of its
  // FileInfo::parts.
  struct Range {
    enum class Of : std::uint8_t { file, points, parts };
    std::size_t file = 0;
    Of of = Of::file;
    std::uint64_t begin = 0, count = 0;
    friend bool operator==(const Range&, const Range&) = default;
  };
  std::vector<Range> ranges;
  bool here = false;  // only this process can read the split, because what is read has no name
};

// The input as one list of points. After opening, the const functions may be called by several threads.
class Cloud {
 public:
  // Finds the files of `patterns` (see InputQuestion), opens every file's header, unpacks compressed files, reads
  // standard input to its end, and settles schema and dimension. Errors: those of find_inputs, Spool and the readers,
  // for the first such file in order; a file without z for a 3D cloud; a file without the attribute by which an option
  // filters; an attribute that no file has; files in different coordinate systems. `stop` ends the call soon, with
  // Errc::interrupted.
  static Result<Cloud> open(const std::vector<std::string>& patterns, CloudOptions options, std::stop_token stop = {});

  // A cloud of one input that is not a file. Errors: as for open().
  static Result<Cloud> open_source(std::shared_ptr<const ByteSource> source, CloudOptions options);

  // A cloud of files that another process has opened. It serves for for_each_batch().
  static Cloud of(std::vector<FileInfo> files, std::vector<Attribute> schema, CloudOptions options);

  const std::vector<FileInfo>& files() const { return files_; }
  const std::vector<Attribute>& schema() const { return schema_; }
  const CloudOptions& options() const { return options_; }
  const std::string& crs() const { return crs_; }    // see settle_crs()
  const std::string& unit() const { return unit_; }  // of the coordinates, if all files state the same; else ""
  const std::vector<std::string>& warnings() const { return warnings_; }

  // Calls `visit` with all points in order, in batches, on the calling thread. `visit` may stop by returning an error.
  // No coordinate is -0. With several threads, small files and parts of text are read ahead, each by one thread. Other
  // large files are read by one thread (LAZ: by all threads) while `visit` works. The batches, and the error if there
  // is one, do not depend on the number of threads.
  Result<CloudCounts> for_each_batch(const std::function<Status(CloudBatch&)>& visit) const;
  // The same for one split. Ids count from its first point. `of_files`, if given, gets one number for each file of the
  // cloud: how many points of the file were read, those that were dropped included.
  Result<CloudCounts> for_each_batch(const InputSplit& split, const std::function<Status(CloudBatch&)>& visit,
                                     std::vector<std::uint64_t>* of_files = nullptr) const;
  // The whole input as one split.
  InputSplit whole() const;

  // Opens file `index` again. The options of the cloud add to `hints`.
  Result<std::unique_ptr<PointReader>> reopen(std::size_t index, const std::vector<Attribute>& schema,
                                              ReadHints hints) const;
  // The same for the whole file: filters of the options are not passed to the reader. source() opens the file's bytes.
  Result<std::unique_ptr<PointReader>> reopen_whole(std::size_t index, const std::vector<Attribute>& schema,
                                                    ReadHints hints) const;
  Result<std::unique_ptr<ByteSource>> source(std::size_t index) const;
  // Whether the bytes of file `index` wait in this process: nobody else can read them.
  bool is_spooled(std::size_t index) const { return spooled_[index] != nullptr; }

 private:
  std::vector<FileInfo> files_;
  std::vector<std::shared_ptr<const ByteSource>> spooled_;  // by file; null where the file itself can be read again
  std::vector<Attribute> schema_;
  std::string crs_, unit_;
  std::vector<std::string> warnings_;
  CloudOptions options_;
};

}  // namespace tessera
