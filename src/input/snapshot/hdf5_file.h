// An HDF5 file, as far as snapshots need it: groups with attributes and tables of numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera::snapshot {

// A table of numbers: `rows` rows of `columns` numbers.
struct Dataset {
  std::string name;
  std::uint64_t rows = 0;
  std::size_t columns = 1;
  AttributeType type = AttributeType::f64;
};

// Reads from a ByteSource, so that whatever reads bytes reads HDF5. What a file may not do: name other files (external
// links, external or virtual datasets), or filters other than deflate, shuffle, checksums, n-bit and scale-offset.
// Errors name the file. Thread-safe.
class Hdf5File {
 public:
  // `source` must outlive the file. Errors: io without the library; bad_input for what is not HDF5.
  static Result<Hdf5File> open(const ByteSource& source);
  Hdf5File(Hdf5File&&) noexcept;
  Hdf5File& operator=(Hdf5File&&) noexcept;
  ~Hdf5File();

  bool has_group(const std::string& name) const;
  // The numbers of an attribute of a group; nothing if the group has no such attribute of numbers.
  std::optional<std::vector<double>> numbers(const std::string& group, const std::string& attribute) const;
  std::optional<std::vector<std::uint64_t>> counts(const std::string& group, const std::string& attribute) const;
  // A number of an attribute of a table; nothing if there is no such attribute, or one of several numbers.
  std::optional<double> number_of_table(const std::string& group, const std::string& table,
                                        const std::string& attribute) const;
  // The tables of numbers of a group, of one or two dimensions. Error bad_input for a table that names other files or
  // an unknown filter.
  Result<std::vector<Dataset>> datasets(const std::string& group) const;
  // Reads whole rows as numbers of the table's type.
  Status read(const std::string& group, const Dataset& dataset, std::uint64_t first_row, std::size_t rows,
              std::span<std::byte> out) const;

 private:
  struct Impl;
  explicit Hdf5File(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::snapshot
