// Several files seen as one cloud, with the filters a user asked for.
#pragma once

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
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

enum class Returns : std::uint8_t { all, first, last, single };

struct CloudOptions {
  // 2 triangulates x and y; z of the points becomes 0. 0: 3, or 2 if the files hold x and y alone.
  int dimension = 3;
  DuplicatePolicy keep = DuplicatePolicy::first;  // 2D: which of the points of equal x and y
  bool heights = true;                            // 2D: carry z as the attribute "z", if any file has it
  bool skip_invalid = false;                      // drop non-finite points and count them, instead of refusing the file
  std::optional<Box> crop = {};                   // closed box: points outside are not part of the cloud
  std::vector<int> classes = {};                  // keep these LAS classes only; empty keeps all
  Returns returns = Returns::all;                 // keep these echoes of each pulse only
  std::vector<std::string> without = {};          // drop points with one of these flags: "withheld", "synthetic", ...
  std::vector<std::string> attributes = {};       // names to carry, or {"all"}
  std::vector<std::string> columns = {};          // text, NumPy: what their columns are called; see ReadHints
  double resolution = 0;                          // COPC files only: how far apart points may be; 0 keeps all
  std::uint32_t threads = 1;                      // that may open, read and unpack files at once
  std::string crs = {};         // WKT or "EPSG:n" of all files, whatever they say; empty: what they say
  std::string input_list = {};  // a file that names further inputs, see InputQuestion
  bool recursive = false;       // folders with their subfolders
  // Where standard input and what is in compressed files wait, without names; empty: the system's temporary folder.
  std::filesystem::path spool_folder = {};
  std::uint64_t spool_bytes_max = 0;  // that may wait there; 0: what the disk has
};

// The point flags of LAS, as attributes are called.
inline constexpr std::array<std::string_view, 4> point_flags{"withheld", "synthetic", "overlap", "key_point"};

// Points with their source index (rank in the whole input, filtered and rejected points counted).
struct CloudBatch {
  std::vector<LocalPoint> points;
  std::vector<std::byte> rows;
};

struct CloudCounts {
  std::uint64_t read = 0;      // points in the files
  std::uint64_t invalid = 0;   // not finite, dropped by --skip-invalid
  std::uint64_t filtered = 0;  // outside the crop box, of another class, or of a level finer than the resolution
  // Of points that were filtered one by one: where they are, and their classes, when a class was asked for.
  Bounds outside = {};
  std::bitset<256> other_classes = {};

  void add(const CloudCounts& more) {
    read += more.read;
    invalid += more.invalid;
    filtered += more.filtered;
    outside.add(more.outside);
    other_classes |= more.other_classes;
  }
};

// A part of the input that can be read by itself.
struct InputSplit {
  // A file, or of one that can be entered in the middle points begin..begin+count-1, or these of its FileInfo::parts.
  struct Range {
    enum class Of : std::uint8_t { file, points, parts };
    std::size_t file = 0;
    Of of = Of::file;
    std::uint64_t begin = 0, count = 0;
    friend bool operator==(const Range&, const Range&) = default;
  };
  std::vector<Range> ranges;
  bool here = false;  // by this process alone: what is read has no name
};

class Cloud {
 public:
  // Finds the files that `patterns` mean (see InputQuestion), opens every file's header, unpacks compressed files and
  // reads standard input to its end, and settles schema and dimension. Errors: those of find_inputs, Spool and the
  // readers, of the first such file in order; a file without z for a 3D cloud or without classes to choose from; an
  // attribute that no file has; files in different coordinate systems. `stop` ends it soon, with Errc::interrupted.
  static Result<Cloud> open(const std::vector<std::string>& patterns, CloudOptions options, std::stop_token stop = {});

  // A cloud of one input that is not a file. Errors as above.
  static Result<Cloud> open_source(std::shared_ptr<const ByteSource> source, CloudOptions options);

  // A cloud of files that another process has opened: of a stretch as much as for_each_batch() asks for.
  static Cloud of(std::vector<FileInfo> files, std::vector<Attribute> schema, CloudOptions options);

  const std::vector<FileInfo>& files() const { return files_; }
  const std::vector<Attribute>& schema() const { return schema_; }
  const CloudOptions& options() const { return options_; }
  const std::string& crs() const { return crs_; }  // see settle_crs()
  const std::vector<std::string>& warnings() const { return warnings_; }

  // Every point in order, in batches; `visit`, which is called on the calling thread, may stop by returning an error.
  // Coordinates have no -0. With several threads, small files and parts of text are read ahead, each by one thread;
  // other large files are read by one thread (LAZ: as many as there are) while `visit` works. Batches, and the error if
  // there is one, do not depend on the number of threads.
  Result<CloudCounts> for_each_batch(const std::function<Status(CloudBatch&)>& visit) const;
  // The same of a stretch; ids count from its first point.
  Result<CloudCounts> for_each_batch(const InputSplit& split, const std::function<Status(CloudBatch&)>& visit) const;

  // All of it in order, cut into stretches of about so many points where files can be entered. Looks at the files that
  // are larger. Errors of the readers.
  Result<std::vector<InputSplit>> splits(std::uint64_t points) const;
  InputSplit whole() const;

  // About `wanted` points spread over all files, deterministic, filters applied. Reads blocks where the format can
  // seek cheaply, everything else whole.
  Result<std::vector<Point>> sample(std::size_t wanted) const;

 private:
  friend class CloudUnits;
  // The reader of file `index`; `hints` without what the options say.
  Result<std::unique_ptr<PointReader>> reopen(std::size_t index, const std::vector<Attribute>& schema,
                                              ReadHints hints) const;
  // The same of the whole file, whatever the options say; and what its bytes are read from.
  Result<std::unique_ptr<PointReader>> reopen_whole(std::size_t index, const std::vector<Attribute>& schema,
                                                    ReadHints hints) const;
  Result<std::unique_ptr<ByteSource>> source(std::size_t index) const;

  std::vector<FileInfo> files_;
  std::vector<std::shared_ptr<const ByteSource>> spooled_;  // by file: none where the file itself is read again
  std::vector<Attribute> schema_;
  std::string crs_;
  std::vector<std::string> warnings_;
  CloudOptions options_;
};

}  // namespace tessera
