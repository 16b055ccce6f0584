#include "src/input/ept/ept_reader.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <utility>

#include "src/input/bytes/far_source.h"
#include "src/input/ept/ept_known.h"
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
  EptReader(std::unique_ptr<ByteSource> source, std::shared_ptr<const ept::Known> known, FileInfo info,
            std::vector<Chosen> nodes, std::uint64_t passed_over_at_end, std::vector<Attribute> attributes,
            std::uint32_t threads)
      : source_(std::move(source)),
        known_(std::move(known)),
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
        BOOST_OUTCOME_TRYV(bring_ahead());
        BOOST_OUTCOME_TRY(opened, ept::open_tile(*source_, *known_, node, attributes_, threads_));
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
    // What follows may be another seek(), so at first no tile is brought before it is needed.
    brought_ = node_;
    ahead_ = 1;
    return true;
  }

  std::string place(std::size_t index) const override {
    const std::string where = "tile " + nodes_[last_].node.key.text();
    return tile_ == nullptr ? where : where + ", " + tile_->place(index);
  }

 private:
  // Fetches the next tiles of a cloud on a server, the more the longer it was read in order.
  Status bring_ahead() {
    const std::uint64_t bytes_max = near_bytes_max(*source_) / 2;
    if (bytes_max == 0 || node_ < brought_) return success();
    std::vector<std::filesystem::path> tiles;
    std::uint64_t bytes = 0;
    for (brought_ = node_; brought_ < nodes_.size() && tiles.size() < ahead_; ++brought_) {
      const ept::Node& node = nodes_[brought_].node;
      bytes += node.points * known_->info.record_bytes;
      if (!tiles.empty() && bytes > bytes_max) break;
      tiles.push_back(ept::tile_file(known_->info, node.key));
    }
    ahead_ = std::min(2 * ahead_, ept::files_at_once);
    return known_->files.bring(*source_, tiles);
  }

  Status end(PointBatch& batch, std::uint64_t skipped) {
    batch.points.clear();
    batch.rows.clear();
    batch.passed_over = skipped + std::exchange(passed_over_at_end_, 0);
    return source_->check_unchanged();
  }

  std::unique_ptr<ByteSource> source_;
  std::shared_ptr<const ept::Known> known_;
  FileInfo info_;
  std::vector<Chosen> nodes_;
  std::uint64_t passed_over_at_end_;
  std::vector<Attribute> attributes_;
  std::uint32_t threads_;
  std::unique_ptr<PointReader> tile_;                     // of nodes_[node_]; null before it is opened
  std::size_t node_ = 0, last_ = 0;                       // the next node; the node of the last batch
  std::uint64_t enter_at_ = 0;                            // the record of the tile to go to
  std::size_t brought_ = 0, ahead_ = ept::files_at_once;  // the first node that was not brought; how many are next
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_ept(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRY(known, ept::know(*source));
  const ept::Info& ept = known->info;
  const std::vector<ept::Node>& nodes = known->nodes;
  FileInfo info = info_of(*source, "ept");
  constexpr std::array<const char*, 3> kinds{"LAZ", "binary", "Zstandard"};
  info.detail = std::string("EPT, tiles in ") + kinds[static_cast<std::size_t>(ept.tiles)];
  if (!ept.conforming.empty()) info.bounds = ept.conforming;
  info.step = {ept.slack(), ept.slack(), ept.slack()};
  info.crs = ept.crs;
  info.crs_note = ept.crs_note;
  info.levels = true;
  info.attributes = known->attributes;
  if (ept.tiles == ept::Info::Tiles::laz) info.seek_points = ept.points / nodes.size() / 2;
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
  return std::unique_ptr<PointReader>(new EptReader(std::move(source), std::move(known), std::move(info),
                                                    std::move(chosen), passed_over, attributes, hints.threads));
}

}  // namespace tessera
