// Writes HDF5 files: tables of numbers, with attributes, in groups.
//
// HDF5 itself makes only the description of the file, in memory. The numbers of a table lie one after the other in the
// file, so they are written without HDF5, in any order and by several threads. The same description and numbers give
// the same bytes: the file has no times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"

namespace tessera {

// A text, or a list of numbers. A list of one number is stored as a single number.
struct Hdf5Attribute {
  std::string name;
  std::variant<std::string, std::vector<double>, std::vector<std::int64_t>> value;
};

struct Hdf5Table {
  std::string name;                  // "density", or with groups: "columns/density"
  std::vector<std::uint64_t> shape;  // the last index varies fastest; at least one
  AttributeType type = AttributeType::f64;
  std::vector<Hdf5Attribute> attributes = {};
};

// A group that has attributes. The groups of tables need no such entry.
struct Hdf5Group {
  std::string name;
  std::vector<Hdf5Attribute> attributes = {};
};

struct Hdf5Layout {
  std::vector<Hdf5Attribute> attributes = {};  // of the file
  std::vector<Hdf5Group> groups = {};
  std::vector<Hdf5Table> tables = {};
};

class Hdf5Output {
 public:
  // Makes a file that is called `target` after commit() alone; without commit() nothing stays. Numbers that are never
  // written are 0. Errors: io without the library HDF5; usage for what HDF5 refuses, such as two tables of one name, or
  // an attribute of more than 64 KiB; io.
  static Result<Hdf5Output> create(const std::filesystem::path& target, const Hdf5Layout& layout);

  // Writes the bytes of numbers of the table's type from number `first` on, counted in the order of the file. Thread-
  // safe. Error io.
  Status write(std::size_t table, std::uint64_t first, std::span<const std::byte> numbers) const;
  // Publishes the file, and returns its size in bytes. Error io.
  Result<std::uint64_t> commit();

 private:
  // Where the numbers of a table are.
  struct Place {
    std::uint64_t at = 0, bytes = 0;
    std::size_t number_bytes = 0;
  };
  Hdf5Output(std::filesystem::path target, TemporaryFile temporary, FileHandle file, std::vector<Place> tables)
      : target_(std::move(target)),
        temporary_(std::move(temporary)),
        file_(std::move(file)),
        tables_(std::move(tables)) {}

  std::filesystem::path target_;
  TemporaryFile temporary_;
  FileHandle file_;
  std::vector<Place> tables_;
};

}  // namespace tessera
