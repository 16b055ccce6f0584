// What the tests of readers and writers share: files made in memory, folders that vanish, points out of a reader.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera::testing_io {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return Bytes(begin, begin + text.size());
}

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
  if (bytes.size() < at + sizeof value) bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
void push(Bytes& bytes, T value, bool swapped = false) {
  std::byte raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof value);
  if (swapped) std::reverse(raw, raw + sizeof raw);
  bytes.insert(bytes.end(), raw, raw + sizeof raw);
}

inline Result<std::unique_ptr<PointReader>> open_bytes(Bytes bytes, const std::string& name,
                                                       std::vector<Attribute> schema = {},
                                                       const ReadHints& hints = {}) {
  return open_reader(memory_source(name, std::move(bytes)), std::move(schema), hints);
}

struct Contents {
  FileInfo info;
  std::vector<Point> points;
  Bytes rows;
};

inline Result<Contents> read_whole(PointReader& reader) {
  Contents contents{.info = reader.info(), .points = {}, .rows = {}};
  PointBatch batch;
  while (true) {
    BOOST_OUTCOME_TRYV(reader.next(batch));
    if (batch.points.empty()) return contents;
    contents.points.insert(contents.points.end(), batch.points.begin(), batch.points.end());
    contents.rows.insert(contents.rows.end(), batch.rows.begin(), batch.rows.end());
  }
}

inline Result<Contents> read_bytes(Bytes bytes, const std::string& name, std::vector<Attribute> schema = {},
                                   const ReadHints& hints = {}) {
  BOOST_OUTCOME_TRY(reader, open_bytes(std::move(bytes), name, std::move(schema), hints));
  return read_whole(*reader);
}

inline Result<Contents> read_text(std::string_view text, const std::string& name, std::vector<Attribute> schema = {}) {
  return read_bytes(bytes_of(text), name, std::move(schema));
}

inline Result<Contents> read_path(const std::filesystem::path& path, std::vector<Attribute> schema = {}) {
  BOOST_OUTCOME_TRY(reader, open_reader(path, std::move(schema)));
  return read_whole(*reader);
}

// The sentence of an error, "" if there is none.
template <class T>
std::string sentence(const Result<T>& result) {
  return result.has_error() ? in_plain_words(result.error().where) : "";
}

// Attribute `column` of row `row` as a number; `schema` as asked for.
template <class T>
T cell(const Contents& contents, const std::vector<Attribute>& schema, std::size_t row, std::size_t column) {
  std::size_t at = row * row_bytes(schema);
  for (std::size_t i = 0; i < column; ++i) at += size_of(schema[i].type);
  T value;
  EXPECT_EQ(sizeof value, size_of(schema[column].type));
  std::memcpy(&value, contents.rows.data() + at, sizeof value);
  return value;
}

class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tessera-io-XXXXXX").string();
    path_ = ::mkdtemp(pattern.data());
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder() {
    std::error_code ignored;  // a folder left in /tmp must not fail a test
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, const Bytes& bytes) const {
    const auto file = path_ / name;
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return file;
  }
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    return write(name, bytes_of(text));
  }

 private:
  std::filesystem::path path_;
};

}  // namespace tessera::testing_io
