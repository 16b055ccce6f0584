#include "src/result/alpha/shape_ply.h"

#include <cstddef>
#include <limits>
#include <utility>

#include "src/base/image.h"
#include "src/result/export/output.h"

namespace tessera::alpha {

namespace fs = std::filesystem;

namespace {

class Writer : public ShapePly {
 public:
  Writer(exports::OutputFile file, const ShapePlyHead& head)
      : file_(std::move(file)), stream_(file_, 0), head_(head), small_ids_(head.ids <= std::uint64_t{1} << 32) {}

  Status begin(const ShapeCounts& counts) override {
    if (counts.vertices > std::numeric_limits<std::uint32_t>::max())
      return error(Errc::usage, file_.target().string() +
                                    ": the alpha shape has more vertices than PLY can number, which is 2^32 - 1");
    const std::uint64_t facets = counts.of(SimplexKind::facet) + counts.of(SimplexKind::singular_facet);
    stream_.text("ply\nformat binary_little_endian 1.0\ncomment " + head_.comment + "\ncomment " +
                 comment_of(head_.stamp) + "\nelement vertex " + std::to_string(counts.vertices) +
                 "\nproperty double x\nproperty double y\nproperty double z\nproperty " +
                 (small_ids_ ? "uint" : "double") + " id\n" +
                 (head_.periodic ? "property char offset_x\nproperty char offset_y\nproperty char offset_z\n" : ""));
    if (head_.dimension == 3)
      stream_.text("element face " + std::to_string(facets) + "\nproperty list uchar uint vertex_indices\n" +
                   (head_.general ? "property uchar singular\n" : ""));
    if (head_.dimension == 2 || head_.general)
      stream_.text(
          "element edge " + std::to_string(head_.dimension == 2 ? facets : counts.of(SimplexKind::singular_edge)) +
          "\nproperty uint vertex1\nproperty uint vertex2\n" + (head_.general ? "property uchar singular\n" : ""));
    stream_.text("end_header\n");
    return stream_.status();
  }
  Status vertex(PointId id, const Point& at) override {
    stream_.value(at);
    if (small_ids_) {
      stream_.value(static_cast<std::uint32_t>(plain(id).value));
    } else {
      stream_.value(static_cast<double>(plain(id).value));
    }
    if (head_.periodic)
      for (const int by : offset_of(id).by) stream_.value(static_cast<std::int8_t>(by));
    return stream_.status();
  }
  Status simplex(SimplexKind kind, std::span<const std::uint64_t> vertices) override {
    if (kind == SimplexKind::singular_vertex) return success();
    if (vertices.size() == 3) stream_.value(std::uint8_t{3});
    for (const std::uint64_t vertex : vertices) stream_.value(static_cast<std::uint32_t>(vertex));
    if (head_.general) stream_.value(static_cast<std::uint8_t>(kind == SimplexKind::facet ? 0 : 1));
    return stream_.status();
  }
  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(stream_.flush());
    return file_.finish();
  }

 private:
  exports::OutputFile file_;
  exports::Stream stream_;
  ShapePlyHead head_;
  bool small_ids_;
};

}  // namespace

Result<std::unique_ptr<ShapePly>> ShapePly::create(const fs::path& target, const ShapePlyHead& head) {
  BOOST_OUTCOME_TRY(file, exports::OutputFile::create(target));
  return std::make_unique<Writer>(std::move(file), head);
}

}  // namespace tessera::alpha
