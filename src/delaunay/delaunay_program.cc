#include "src/delaunay/delaunay_program.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "src/delaunay/duplicates.h"

namespace tessera {
namespace {

class FinishedTile final : public Finished {
 public:
  FinishedTile(TileId self, CollectedTile tile, DelaunayStore& store)
      : self_(self), tile_(std::move(tile)), store_(store) {}
  std::uint64_t bytes() const override { return tile_.bytes(); }
  void store(Stored done) override { store_.store(self_, std::move(tile_), std::move(done)); }

 private:
  TileId self_;
  CollectedTile tile_;
  DelaunayStore& store_;
};

}  // namespace

std::unique_ptr<TileProgram> DelaunayStage::program_of(TileId tile) const {
  return std::make_unique<DelaunayProgram>(tile, *this);
}

// `announce`: the exchange follows; else the tile is finished next.
Status DelaunayProgram::build(bool announce) {
  finals_.clear();
  gone_ = {};
  BOOST_OUTCOME_TRY(loaded, stage_.store->load_points(self_));
  own_points_ = loaded.points.size();
  if (!loaded.duplicates.empty()) {
    const auto pairs = duplicates_for_scratch(std::exchange(loaded.duplicates, {}), loaded.other_heights);
    BOOST_OUTCOME_TRYV(stage_.storage->write(self_, ScratchKind::duplicates, std::as_bytes(std::span(pairs))));
  }
  const Box& box = (*stage_.boxes)[self_.value];
  triangulation_ = std::make_unique<TileTriangulation>(options());
  // If the tile is not reduced, the points are kept until finish(). Moving the vector leaves them where they are.
  triangulation_->triangulate(loaded.points, loaded.ids, KeepPoints::borrowed);
  // A tile that is collected next need not be reduced, except to store its early cells.
  if (!keeps_cells()) {
    if (announce) discard(loaded, box);
  } else if (stage_.stores_early(own_points_) || (stage_.reduce && announce)) {
    FinalCells finals = triangulation_->reduce(loaded.points, box, !stage_.reduce || !announce);
    if (triangulation_->handed_out()) {
      BOOST_OUTCOME_TRYV(finals_.keep(std::move(finals), loaded.ids, !announce));
    }
  }
  if (announce && box.lo.x < box.hi.x) triangulation_->announce(loaded.points, box);
  // the triangulation has them, too
  if (!keeps_cells() && !triangulation_->reduced()) std::vector<PointId>().swap(loaded.ids);
  if (!triangulation_->reduced() || !announce) points_ = std::make_unique<LoadedTile>(std::move(loaded));
  counts_ = triangulation_->counts();
  return success();
}

Status DelaunayProgram::begin_settled(Message settled) {
  if (settled.size() % sizeof(SharedPoint) != 0) return damaged(self_, "list of foreign vertices");
  BOOST_OUTCOME_TRYV(take(self_, true, std::move(settled)));
  BOOST_OUTCOME_TRYV(build(false));
  return heard_.insert_into(*triangulation_, stage_.dimension);
}

// Told bits are valid only if the sender goes by the same routing table.
Status DelaunayProgram::take(TileId from, bool current, Message message) {
  return heard_.add(self_, from, message, current ? ~std::uint32_t{0} : 0);
}

Status DelaunayProgram::step() {
  BOOST_OUTCOME_TRYV(finals_.stored_so_far());  // a full disk is noticed now, not at the end
  BOOST_OUTCOME_TRYV(heard_.insert_into(*triangulation_, stage_.dimension));
  triangulation_->introduce();
  counts_ = triangulation_->counts();
  return success();
}

std::vector<std::pair<TileId, Message>> DelaunayProgram::messages() {
  if (!triangulation_) return {};
  return messages_of(*triangulation_);
}

// The star of a point among the tile's own points and the point's neighbours is its star among all points, and further
// points do not change it. So all foreign vertices are written, which include the neighbours.
Message DelaunayProgram::settled() const {
  const std::vector<SharedPoint> foreign = triangulation_->foreign_vertices();
  const auto bytes = std::as_bytes(std::span(foreign));
  return Message(bytes.begin(), bytes.end());
}

Result<std::unique_ptr<Finished>> DelaunayProgram::finish() {
  if (!keeps_cells()) return finish_points();
  if (!points_) {
    BOOST_OUTCOME_TRYV(load_own_points());
  }
  PendingFinals finals;
  if (triangulation_->handed_out()) {
    auto taken = finals_.take(own_points_);
    // no tile can begin from this image again, as it needs the final cells
    if (!taken && taken.error().code == Errc::corrupt) {
      BOOST_OUTCOME_TRYV(stage_.storage->remove(self_, ScratchKind::state));
    }
    if (!taken) return taken.error();
    finals = std::move(taken).value();
  }
  CollectedTile tile = triangulation_->collect(std::move(points_->points), std::move(points_->ids), std::move(finals));
  BOOST_OUTCOME_TRY(stored, finals_.take_stored());
  tile.stored = std::move(stored);
  counts_ = triangulation_->counts();
  return std::unique_ptr<Finished>(std::make_unique<FinishedTile>(self_, std::move(tile), *stage_.store));
}

Image DelaunayProgram::save() {
  Image bytes = triangulation_->save();
  const ImageEnd end{own_points_, keeps_cells() ? 0u : 1u, gone_, finals_.sum()};
  const auto last = std::as_bytes(std::span(&end, 1));
  bytes.insert(bytes.end(), last.begin(), last.end());
  earlier_ = false;
  return bytes;
}

// Returns null when the bytes are not what save() has made.
std::unique_ptr<TileTriangulation> DelaunayProgram::decode(Image image, ImageEnd& end) const {
  if (image.size() < sizeof end) return nullptr;
  std::memcpy(&end, image.data() + image.size() - sizeof end, sizeof end);
  image.resize(image.size() - sizeof end);
  if ((end.of_points == 0) != keeps_cells()) return nullptr;
  auto tile = std::make_unique<TileTriangulation>(options());
  if (!tile->load(std::move(image))) return nullptr;
  return tile;
}

Result<bool> DelaunayProgram::load(Image image, ImageOf whose) {
  if (whose == ImageOf::sleeper) return wake(std::move(image));
  return restore(std::move(image), nullptr, whose == ImageOf::settled);
}

Result<bool> DelaunayProgram::wake(Image image) {
  ImageEnd end;
  triangulation_ = decode(std::move(image), end);
  if (!triangulation_ || end.own_points != own_points_ || end.finals_sum != finals_.sum()) return false;
  if (earlier_) triangulation_->forget_told_bits();
  if (!triangulation_->reduced()) {
    BOOST_OUTCOME_TRYV(load_own_points());
  }
  return true;
}

// An image is a correct beginning, whatever the other tiles begin from, if the tile sends again all that it has ever
// sent. What the tile was sent after the image was made is sent again by the tiles that remember it; other tiles begin
// from images, too, or have not sent it yet.
// `finals`: the list of final cells; null: it is on scratch.
Result<bool> DelaunayProgram::restore(Image image, const Image* finals, bool at_once) {
  ImageEnd end;
  auto tile = decode(std::move(image), end);
  if (!tile) return false;
  own_points_ = end.own_points;
  finals_.expect(end.finals_sum);
  gone_ = end.gone;
  if (keeps_cells() && tile->handed_out()) {
    TileStorage::Pieces pieces;
    if (!finals) {
      auto read = stage_.storage->read(self_, ScratchKind::finals);
      if (!read || read.value().size() != 1) return false;
      pieces = std::move(read).value();
    }
    BOOST_OUTCOME_TRY(sound, finals_.restore(finals ? *finals : pieces[0], own_points_, at_once));
    if (!sound) return false;
  }
  triangulation_ = std::move(tile);
  if (!triangulation_->reduced()) {
    BOOST_OUTCOME_TRYV(load_own_points());
  }
  triangulation_->replay();
  counts_ = triangulation_->counts();
  earlier_ = true;
  return true;
}

// Packs into one piece: the image, the tile's list of final cells if there is one, and the length of the image.
Result<Image> DelaunayProgram::pack(Image image) {
  const std::uint64_t of_image = image.size();
  BOOST_OUTCOME_TRY(finals, stage_.storage->read(self_, ScratchKind::finals));
  if (finals.size() > 1) return damaged(self_, "list of final cells");
  if (!finals.empty()) image.insert(image.end(), finals[0].begin(), finals[0].end());
  const auto length = std::as_bytes(std::span(&of_image, 1));
  image.insert(image.end(), length.begin(), length.end());
  return image;
}

Result<bool> DelaunayProgram::load_packed(Image packed) {
  std::uint64_t of_image = 0;
  if (packed.size() < sizeof of_image) return false;
  const std::size_t end = packed.size() - sizeof of_image;
  std::memcpy(&of_image, packed.data() + end, sizeof of_image);
  if (of_image > end) return false;
  const Image finals(packed.begin() + static_cast<std::ptrdiff_t>(of_image),
                     packed.begin() + static_cast<std::ptrdiff_t>(end));
  packed.resize(of_image);
  BOOST_OUTCOME_TRY(restored, restore(std::move(packed), &finals, false));
  earlier_ = false;  // nothing is known of an image that may be on scratch
  return restored;
}

Status DelaunayProgram::load_own_points() {
  BOOST_OUTCOME_TRY(loaded, stage_.store->load_points(self_));
  points_ = std::make_unique<LoadedTile>(std::move(loaded));
  return points_->points.size() == own_points_ ? Status(success()) : damaged(self_, "file of points");
}

void DelaunayProgram::free() {
  triangulation_.reset();
  points_.reset();
  finals_.free();
}

std::size_t DelaunayProgram::memory() const {
  return (triangulation_ ? triangulation_->memory() : 0) + (points_ ? points_->points.size() * 32 : 0) +
         finals_.memory();
}

}  // namespace tessera
