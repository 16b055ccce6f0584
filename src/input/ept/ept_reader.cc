#include "src/input/ept/ept_reader.h"

#include <array>
#include <string>
#include <utility>

#include "src/input/ept/ept_nodes.h"
#include "src/input/ept/ept_tile.h"
#include "src/input/file_part.h"

namespace tessera {
namespace {

// A node, and the points that are left out between the node before and this one.
struct Chosen {
  ept::Node node;
  std::uint64_t passed_over = 0;
};

class EptReader : public PointReader {
 public:
  EptReader(std::unique_ptr<ByteSource> source, ept::Info ept, FileInfo info, std::vector<Chosen> nodes,
            std::uint64_t passed_over_at_end, std::vector<Attribute> attributes, std::uint32_t threads)
      : source_(std::move(source)),
        ept_(std::move(ept)),
        info_(std::move(info)),
        nodes_(std::move(nodes)),
        passed_over_at_end_(passed_over_at_end),
        attributes_(std::move(attributes)),
        threads_(threads) {}

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    std::uint64_t skipped = 0;
    while (true) {
      if (tile_ == nullptr) {
        if (node_ == nodes_.size()) return end(batch, skipped);
        const auto& [node, passed_over] = nodes_[node_];
        BOOST_OUTCOME_TRY(opened, ept::open_tile(ept_, node, attributes_, threads_));
        tile_ = std::move(opened);
        if (enter_at_ > 0) {
          BOOST_OUTCOME_TRYV(tile_->seek(enter_at_));
        } else {
          skipped += passed_over;
        }
        enter_at_ = 0;
      }
      BOOST_OUTCOME_TRYV(tile_->next(batch, most));
      if (!batch.points.empty()) {
        last_ = node_;
        batch.passed_over = skipped;
        return success();
      }
      tile_.reset();
      ++node_;
    }
  }

  Result<bool> seek(std::uint64_t index) override {
    tile_.reset();
    enter_at_ = 0;
    node_ = 0;
    // Numbers count the points that this reader gives.
    while (node_ < nodes_.size() && index >= nodes_[node_].node.points) index -= nodes_[node_++].node.points;
    if (node_ < nodes_.size()) enter_at_ = index;
    return true;
  }

  std::string place(std::size_t index) const override {
    const std::string where = "tile " + nodes_[last_].node.key.text();
    return tile_ == nullptr ? where : where + ", " + tile_->place(index);
  }

 private:
  Status end(PointBatch& batch, std::uint64_t skipped) {
    batch.points.clear();
    batch.rows.clear();
    batch.passed_over = skipped + std::exchange(passed_over_at_end_, 0);
    return source_->check_unchanged();
  }

  std::unique_ptr<ByteSource> source_;
  ept::Info ept_;
  FileInfo info_;
  std::vector<Chosen> nodes_;
  std::uint64_t passed_over_at_end_;
  std::vector<Attribute> attributes_;
  std::uint32_t threads_;
  std::unique_ptr<PointReader> tile_;  // of nodes_[node_]; null before it is opened
  std::size_t node_ = 0, last_ = 0;    // the next node; the node of the last batch
  std::uint64_t enter_at_ = 0;         // the record of the tile to go to
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_ept(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRY(ept, ept::read_info(*source));
  BOOST_OUTCOME_TRY(nodes, ept::read_nodes(ept));
  FileInfo info = info_of(*source, "ept");
  if (nodes.empty()) return error(Errc::bad_input, info.path.string() + ": holds no points");
  constexpr std::array<const char*, 3> kinds{"LAZ", "binary", "Zstandard"};
  info.detail = std::string("EPT, tiles in ") + kinds[static_cast<std::size_t>(ept.tiles)];
  if (!ept.conforming.empty()) info.bounds = ept.conforming;
  info.step = {ept.slack(), ept.slack(), ept.slack()};
  info.crs = ept.crs;
  info.crs_note = ept.crs_note;
  info.levels = true;
  if (ept.tiles == ept::Info::Tiles::laz) {
    BOOST_OUTCOME_TRY(first, ept::open_tile(ept, nodes.front(), {}, 1));
    info.attributes = first->info().attributes;
    info.seek_points = ept.points / nodes.size() / 2;
  } else {
    info.attributes = ept::attributes_of(ept);
  }
  const std::int32_t levels = ept::levels_for(ept, hints.resolution);
  std::vector<Chosen> chosen;
  std::uint64_t given = 0, passed_over = 0;
  for (const auto& node : nodes) {
    if (node.key.level >= levels || (hints.crop && !meets(ept::bounds_of(ept, node.key), *hints.crop))) {
      passed_over += node.points;
      continue;
    }
    chosen.push_back({node, std::exchange(passed_over, 0)});
    given += node.points;
  }
  info.points = given;
  info.points_passed_over = ept.points - given;
  return std::unique_ptr<PointReader>(new EptReader(std::move(source), std::move(ept), std::move(info),
                                                    std::move(chosen), passed_over, attributes, hints.threads));
}

}  // namespace tessera
