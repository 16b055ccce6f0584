// A cloud in EPT, whose files are parts of one input.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/input/bytes/far_source.h"
#include "src/input/ept/ept_known.h"
#include "tests/fuzz/read_stranger.h"

namespace tessera {

// The file `name` of a cloud on a server. The bytes are ept.json, the first page of the hierarchy, all other pages and
// all tiles, with zero bytes between them.
class StrangerEpt : public FarSource {
 public:
  StrangerEpt(std::filesystem::path name, std::span<const std::byte> bytes)
      : path_(std::move(name)), all_(bytes), part_(part_of(path_.string(), bytes)) {}

  const std::filesystem::path& path() const override { return path_; }
  std::uint64_t size() const override { return part_.size(); }
  std::int64_t modified_ns() const override { return 0; }
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    must(offset <= part_.size() && out.size() <= part_.size() - offset);
    std::copy_n(part_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return success();
  }
  Status check_unchanged() const override { return success(); }
  Status bring(std::span<const ByteRange> ranges) const override {
    for (const auto& range : ranges) must(range.begin <= range.end && range.end <= part_.size());
    return success();
  }
  std::uint64_t near_bytes_max() const override { return 1 << 16; }
  Result<std::shared_ptr<const ByteSource>> open_beside(const std::string& name, std::size_t) const override {
    return std::shared_ptr<const ByteSource>(std::make_shared<const StrangerEpt>(name, all_));
  }
  std::shared_ptr<const Learnt> learnt() const override { return learnt_; }
  void learn(std::shared_ptr<const Learnt> what) const override { learnt_ = std::move(what); }

 private:
  static std::span<const std::byte> part_of(const std::string& name, std::span<const std::byte> bytes) {
    std::size_t number = 3;
    if (name.ends_with("ept.json")) number = 0;
    if (name.find("ept-hierarchy") != name.npos) number = name.ends_with("/0-0-0-0.json") ? 1 : 2;
    for (std::size_t i = 0; i < number; ++i) {
      const auto zero = std::find(bytes.begin(), bytes.end(), std::byte{0});
      bytes = bytes.subspan(zero == bytes.end() ? bytes.size() : static_cast<std::size_t>(zero - bytes.begin()) + 1);
    }
    return number == 3 ? bytes
                       : bytes.first(static_cast<std::size_t>(std::find(bytes.begin(), bytes.end(), std::byte{0}) -
                                                              bytes.begin()));
  }

  std::filesystem::path path_;
  std::span<const std::byte> all_, part_;
  mutable std::shared_ptr<const Learnt> learnt_;
};

// Reads the cloud as read_stranger() reads a file, and its nodes as a region does.
inline void read_stranger_ept(const std::uint8_t* data, std::size_t size) {
  const std::string name = "stranger/";
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
  const auto source = std::make_shared<const StrangerEpt>(name + "ept.json", bytes);
  if (source->size() == 0) return;
  const auto named = [&](const Error& error) { return error.where.find(name) == 0; };
  const auto open = [&](const std::vector<Attribute>& schema, const ReadHints& hints) {
    return open_reader(share(source), schema, hints);
  };
  auto first = open({}, {});
  if (first.has_error()) return must(named(first.error()));
  if (first.value()->info().format != "ept") return;
  const auto schema = first.value()->info().attributes;
  for (const ReadHints& hints : {ReadHints{}, stranger_hints()}) {
    auto opened = open(schema, hints);
    must(opened.has_value());
    auto& reader = *opened.value();
    PointBatch batch;
    std::uint64_t count = 0;
    while (true) {
      batch.passed_over = 0;
      const auto status = reader.next(batch);
      if (status.has_error()) {
        must(named(status.error()));
        break;
      }
      if (batch.points.empty()) {
        must(*reader.info().points == count);
        break;
      }
      must(batch.points.size() <= 65536);
      must(batch.rows.size() == batch.points.size() * row_bytes(schema));
      must(!reader.place(0).empty());
      count += batch.points.size();
    }
  }
  const auto parts = ept::read_parts(*source, 0);
  must(parts.has_value() && !parts.value().empty());
  const auto brought = ept::bring_parts(*source, parts.value());
  must(brought.has_value() || named(brought.error()));
}

}  // namespace tessera
