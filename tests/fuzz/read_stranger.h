// What every fuzz target does with its bytes, and the replay test with those of earlier runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/bytes/spool.h"
#include "src/input/cosmology.h"
#include "src/input/reader.h"

namespace tessera {

inline void must(bool holds) {
  if (!holds) std::abort();
}

// A region and a resolution that leave out some nodes of the COPC file in the corpus.
inline ReadHints stranger_hints() {
  return {.crop = Box{.lo = {0, 0, -1e9}, .hi = {1e6, 1e7, 1e9}}, .resolution = 0.5, .threads = 2};
}

// What lets tables of FITS with redshifts be read.
inline ReadHints table_hints() { return {.cosmology = Cosmology{.hubble = 70, .matter = 0.3}}; }

// Reads the bytes as a file of that name, with all its attributes, and holds the reader to its promises: a sentence
// that names the file, or as many points as announced, in batches that are not huge; rows as long as asked for; after a
// seek the same points again.
inline void read_stranger(const std::uint8_t* data, std::size_t size, const std::string& name,
                          const ReadHints& hints = {}) {
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  Spool spool{{}};  // for what is compressed
  const auto open = [&](const std::vector<Attribute>& schema) -> Result<std::unique_ptr<PointReader>> {
    BOOST_OUTCOME_TRY(source, spool.unpacked(memory_source(name, std::vector<std::byte>(begin, begin + size))));
    return open_reader(share(std::move(source)), schema, hints);
  };
  auto first = open({});
  if (first.has_error()) {
    must(first.error().where.find(name) == 0);
    return;
  }
  const auto schema = first.value()->info().attributes;
  auto opened = open(schema);
  must(opened.has_value());
  auto& reader = *opened.value();

  std::uint64_t count = 0;
  std::vector<Point> last;
  PointBatch batch;
  while (true) {
    const auto status = reader.next(batch);
    if (status.has_error()) {
      must(status.error().where.find(name) == 0);
      return;
    }
    if (batch.points.empty()) break;
    must(batch.points.size() <= 65536);
    must(batch.rows.size() == batch.points.size() * row_bytes(schema));
    must(!reader.place(0).empty());
    count += batch.points.size();
    last = batch.points;
  }
  if (reader.info().points) must(*reader.info().points == count);
  const auto can_seek = reader.seek(count - last.size());
  if (!can_seek.has_value() || !can_seek.value() || last.empty()) return;
  must(reader.next(batch).has_value());
  must(batch.points.size() == last.size());
  for (std::size_t i = 0; i < last.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      must(batch.points[i][axis] == last[i][axis] || batch.points[i][axis] != batch.points[i][axis]);
}

}  // namespace tessera
