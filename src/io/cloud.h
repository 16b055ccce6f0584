// Several files seen as one cloud, with the filters a user asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/io/reader.h"

namespace tessera {

struct CloudOptions {
  int dimension = 3;                         // 2 keeps x and y; z becomes 0 (and can be carried as attribute "z")
  bool skip_invalid = false;                 // drop non-finite points and count them, instead of refusing the file
  std::optional<Box> crop = {};              // closed box: points outside are not part of the cloud
  std::vector<int> classes = {};             // keep these LAS classes only; empty keeps all
  std::vector<std::string> attributes = {};  // names to carry, or {"all"}
  double resolution = 0;                     // COPC files only: how far apart points may be; 0 keeps all
  std::uint32_t threads = 1;                 // that may decompress at once
};

// Points with their source index (rank in the whole input, filtered and rejected points counted).
struct CloudBatch {
  std::vector<LocalPoint> points;
  std::vector<std::byte> rows;
};

struct CloudCounts {
  std::uint64_t read = 0;      // points in the files
  std::uint64_t invalid = 0;   // not finite, dropped by --skip-invalid
  std::uint64_t filtered = 0;  // outside the crop box, of another class, or of a level finer than the resolution
};

class Cloud {
 public:
  // Expands globs ("block/*.las"), opens every file's header and settles the schema. Errors: nothing matches, unknown
  // format, a file without z for a 3D cloud or without classes to choose from, an attribute that no file has.
  static Result<Cloud> open(const std::vector<std::string>& patterns, CloudOptions options);

  // A cloud of one input that is not a file: `source` opens it whenever it is read.
  using OpenSource = std::function<std::unique_ptr<ByteSource>()>;
  static Result<Cloud> open_source(OpenSource source, CloudOptions options);

  const std::vector<FileInfo>& files() const { return files_; }
  const std::vector<Attribute>& schema() const { return schema_; }
  const CloudOptions& options() const { return options_; }
  std::string crs() const;  // of the first file that has one

  // Every point in order, in batches; `visit` may stop by returning an error. Coordinates have no -0.
  Result<CloudCounts> for_each_batch(const std::function<Status(CloudBatch&)>& visit) const;

  // About `wanted` points spread over all files, deterministic, filters applied. Reads blocks where the format can
  // seek cheaply, everything else whole.
  Result<std::vector<Point>> sample(std::size_t wanted) const;

 private:
  Result<std::unique_ptr<PointReader>> reopen(const FileInfo& file, const std::vector<Attribute>& schema) const;

  OpenSource source_;  // instead of files
  std::vector<FileInfo> files_;
  std::vector<Attribute> schema_;
  CloudOptions options_;
};

}  // namespace tessera
