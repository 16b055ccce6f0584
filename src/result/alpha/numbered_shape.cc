#include "src/result/alpha/numbered_shape.h"

#include <algorithm>
#include <cerrno>
#include <optional>
#include <utility>
#include <vector>

#include "src/result/export/output.h"

namespace tessera::alpha {

namespace fs = std::filesystem;

namespace {

// The first sorter is emptied while the second one is filled, and so on.
constexpr std::uint64_t sorters_at_once = 2;

}  // namespace

NumberedShape::NumberedShape(int dimension, fs::path scratch, std::uint64_t memory_bytes, std::stop_token stop)
    : dimension_(dimension),
      scratch_(std::move(scratch)),
      sorter_bytes_(memory_bytes / sorters_at_once),
      stop_(std::move(stop)),
      simplices_(scratch_, sorter_bytes_, stop_) {}

Status NumberedShape::add(std::span<const ShapeSimplex> simplices) {
  for (const ShapeSimplex& simplex : simplices) {
    BOOST_OUTCOME_TRYV(simplices_.push(simplex));
  }
  return success();
}

Status NumberedShape::for_each(const std::function<Status(const ShapeSimplex&)>& visit) {
  return simplices_.for_each(visit);
}

Result<ShapeCounts> NumberedShape::spread(ExternalSort<Corner>& corners) {
  ShapeCounts counts;
  std::uint64_t rank = 0;
  BOOST_OUTCOME_TRYV(simplices_.for_each([&](const ShapeSimplex& simplex) -> Status {
    ++counts.simplices[static_cast<std::size_t>(simplex.kind)];
    for (std::size_t k = 0; k < corners_of(simplex.kind, dimension_); ++k) {
      BOOST_OUTCOME_TRYV(corners.push({simplex.ids[k], 4 * rank + k, simplex.at[k]}));
    }
    ++rank;
    return success();
  }));
  simplices_ = ExternalSort<ShapeSimplex>(scratch_, 0, stop_);  // frees its memory and its files
  return counts;
}

// Writes each vertex once. Returns the number of vertices.
Result<std::uint64_t> NumberedShape::number(ExternalSort<Corner>& corners, ExternalSort<Numbered>& numbers,
                                            const FileHandle& file) {
  exports::Stream stream(file.get(), scratch_, 0);
  std::optional<PointId> last;
  std::uint64_t vertices = 0;
  BOOST_OUTCOME_TRYV(corners.for_each([&](const Corner& corner) -> Status {
    if (last != corner.id) {
      stream.value(LocalPoint{corner.at, corner.id});
      ++vertices;
      last = corner.id;
    }
    BOOST_OUTCOME_TRYV(numbers.push({corner.place, vertices - 1}));
    return stream.status();
  }));
  BOOST_OUTCOME_TRYV(stream.flush());
  return vertices;
}

Status NumberedShape::give_vertices(ShapeTaker& taker, const FileHandle& file, std::uint64_t vertices) const {
  std::vector<LocalPoint> buffer(4096);
  for (std::uint64_t done = 0; done < vertices;) {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while writing an alpha shape");
    const auto wanted = std::span(buffer).first(std::min<std::uint64_t>(buffer.size(), vertices - done));
    const auto bytes = std::as_writable_bytes(wanted);
    BOOST_OUTCOME_TRY(read, read_up_to(file.get(), bytes, done * sizeof(LocalPoint), scratch_));
    if (read != bytes.size()) return io_error(scratch_, "cannot read back", EIO);
    for (const LocalPoint& vertex : wanted) {
      BOOST_OUTCOME_TRYV(taker.vertex(vertex.id, vertex.at));
    }
    done += wanted.size();
  }
  return success();
}

Status NumberedShape::give(ShapeTaker& taker) {
  ExternalSort<Numbered> numbers(scratch_, sorter_bytes_, stop_);
  ShapeCounts counts;
  BOOST_OUTCOME_TRY(file, nameless_file(scratch_));
  {
    ExternalSort<Corner> corners(scratch_, sorter_bytes_, stop_);
    BOOST_OUTCOME_TRY(found, spread(corners));
    counts = found;
    BOOST_OUTCOME_TRY(vertices, number(corners, numbers, file));
    counts.vertices = vertices;
  }
  BOOST_OUTCOME_TRYV(taker.begin(counts));
  BOOST_OUTCOME_TRYV(give_vertices(taker, file, counts.vertices));
  std::array<std::uint64_t, 3> vertices{};
  std::size_t corner = 0, kind = 0;
  std::uint64_t of_kind = 0;
  return numbers.for_each([&](const Numbered& numbered) -> Status {
    for (; of_kind == counts.simplices[kind]; of_kind = 0) ++kind;
    const std::size_t size = corners_of(static_cast<SimplexKind>(kind), dimension_);
    vertices[corner++] = numbered.number;
    if (corner < size) return success();
    corner = 0;
    ++of_kind;
    return taker.simplex(static_cast<SimplexKind>(kind), std::span(vertices).first(size));
  });
}

}  // namespace tessera::alpha
