#include "src/delaunay/update/changed_program.h"

#include <cstring>
#include <string>

namespace tessera {
namespace {

class ChangedEnd final : public Finished {
 public:
  ChangedEnd(UpdateStore& store, TileId tile, TileEnd end, std::unique_ptr<CollectedTile> cells)
      : store_(store), tile_(tile), end_(std::move(end)), cells_(std::move(cells)) {}
  std::uint64_t bytes() const override { return cells_ ? cells_->bytes() : 0; }
  void store(Stored done) override {
    Status stored = store_.store(tile_, std::move(end_), cells_.get());
    cells_.reset();
    done(stored ? Result<Receipt>(Receipt()) : Result<Receipt>(std::move(stored).error()));
  }

 private:
  UpdateStore& store_;
  TileId tile_;
  TileEnd end_;
  std::unique_ptr<CollectedTile> cells_;
};

// Of a tile that the change does not name, and that nothing has woken.
class Untouched final : public Finished {
 public:
  std::uint64_t bytes() const override { return 0; }
  void store(Stored done) override { done(Receipt()); }
};

}  // namespace

TileOptions ChangedProgram::options() const {
  return {.self = self_, .dimension = setting_->dimension, .around = setting_->around.get(), .stop = setting_->stop};
}

Result<bool> ChangedProgram::concerns() const {
  const UpdatePlan& plan = *setting_->plan;
  if (plan.added.contains(self_) || plan.losing.contains(self_)) return true;
  if (plan.removed.empty()) return false;
  BOOST_OUTCOME_TRY(told, setting_->store->told(self_));
  return told.beside;
}

// `cells`: whether fresh points are to be found. Only a tile where points were removed needs its cells for that.
Status ChangedProgram::read(bool cells) {
  const UpdatePlan& plan = *setting_->plan;
  ToldOfHoles told;
  if (!plan.removed.empty()) {
    BOOST_OUTCOME_TRY(kept, setting_->store->told(self_));
    told = std::move(kept);
  }
  BOOST_OUTCOME_TRY(mesh, setting_->store->read(self_, cells && (told.beside || plan.losing.contains(self_))));
  start_ = std::make_unique<StartOfTile>(start_of(self_, std::move(mesh), plan, told));
  return success();
}

// REQUIRES: read() was called.
Status ChangedProgram::build() {
  triangulation_ = std::make_unique<TileTriangulation>(options());
  const auto common = start_->begins ? setting_->plan->common : std::nullopt;
  BOOST_OUTCOME_TRYV(triangulation_->triangulate_changed(
      {start_->points, start_->ids, start_->fresh, start_->foreign, common}, KeepPoints::borrowed));
  lost_ = start_->lost;
  std::vector<SharedPoint>().swap(start_->foreign);
  std::vector<std::uint8_t>().swap(start_->fresh);
  return success();
}

Status ChangedProgram::begin() {
  BOOST_OUTCOME_TRY(concerned, concerns());
  if (!concerned) return success();
  BOOST_OUTCOME_TRYV(read(true));
  begun_ = start_->begins;
  reshaped_ = start_->reshaped;
  if (begun_) return build();
  start_.reset();
  return success();
}

// The star of a point among the tile's own points and the point's neighbours is its star among all points, so the
// foreign vertices at the end are all that the tile needs.
Status ChangedProgram::begin_settled(Message settled) {
  LastPart last;
  if (!take_last_part(settled, last) || settled.size() % sizeof(SharedPoint) != 0)
    return damaged(self_, "list of foreign vertices");
  if (last.built != 0) {
    BOOST_OUTCOME_TRYV(read(false));
    start_->begins = false;
    start_->fresh.assign(start_->points.size(), 0);
    start_->foreign.resize(settled.size() / sizeof(SharedPoint));
    if (!settled.empty()) std::memcpy(start_->foreign.data(), settled.data(), settled.size());
    put_in_hilbert_order(start_->foreign, setting_->dimension);
    BOOST_OUTCOME_TRYV(build());
  }
  go_by(last);
  return success();
}

// Told bits are valid only if the sender goes by the same routing table. Whether a point is fresh never changes.
Status ChangedProgram::take(TileId from, bool current, Message message) {
  return heard_.add(self_, from, message, current ? ~std::uint32_t{0} : fresh_bit);
}

Status ChangedProgram::step() {
  if (!triangulation_) {
    if (heard_.empty()) return success();
    BOOST_OUTCOME_TRYV(read(false));
    BOOST_OUTCOME_TRYV(build());
  }
  BOOST_OUTCOME_TRYV(heard_.insert_into(*triangulation_, setting_->dimension));
  triangulation_->introduce();
  counts_ = triangulation_->counts();
  return success();
}

std::vector<std::pair<TileId, Message>> ChangedProgram::messages() {
  if (!triangulation_) return {};
  return messages_of(*triangulation_);
}

bool ChangedProgram::take_last_part(BigVector<std::byte>& bytes, LastPart& last) {
  if (bytes.size() < sizeof last) return false;
  std::memcpy(&last, bytes.data() + bytes.size() - sizeof last, sizeof last);
  bytes.resize(bytes.size() - sizeof last);
  return last.built <= 1 && last.begun <= 1 && last.lost <= 1 && last.reshaped <= 1 &&
         (last.built != 0 || bytes.empty());
}

void ChangedProgram::go_by(const LastPart& last) {
  begun_ = last.begun != 0;
  lost_ = last.lost != 0;
  reshaped_ = last.reshaped != 0;
  counts_ = last.counts;
}

namespace {

template <class Part>
BigVector<std::byte> with(BigVector<std::byte> bytes, const Part& last) {
  const auto part = std::as_bytes(std::span(&last, 1));
  bytes.insert(bytes.end(), part.begin(), part.end());
  return bytes;
}

}  // namespace

Image ChangedProgram::save() {
  earlier_ = false;
  return with(triangulation_ ? triangulation_->save() : Image(), last_part());
}

// As in DelaunayProgram: an image is a right beginning if the tile sends again all that it has ever sent.
Result<bool> ChangedProgram::load(Image image, ImageOf whose) {
  LastPart last;
  if (!take_last_part(image, last)) return false;
  start_.reset();
  triangulation_.reset();
  if (last.built != 0) {
    auto tile = std::make_unique<TileTriangulation>(options());
    if (!tile->load(std::move(image))) return false;
    triangulation_ = std::move(tile);
    if (whose != ImageOf::sleeper) {
      triangulation_->replay();
      earlier_ = true;
    } else if (earlier_) {
      triangulation_->forget_told_bits();
    }
  }
  go_by(last);
  return true;
}

Result<bool> ChangedProgram::load_packed(Image packed) {
  BOOST_OUTCOME_TRY(loaded, load(std::move(packed), ImageOf::earlier));
  earlier_ = false;  // nothing is known of an image that may be on scratch
  return loaded;
}

void ChangedProgram::free() {
  triangulation_.reset();
  start_.reset();
}

Message ChangedProgram::settled() const {
  Message settled;
  if (triangulation_) {
    const std::vector<SharedPoint> foreign = triangulation_->foreign_vertices();
    const auto bytes = std::as_bytes(std::span(foreign));
    settled.assign(bytes.begin(), bytes.end());
  }
  return with(std::move(settled), last_part());
}

// If one tile is flat at the end, all are (docs/updates-design.md).
Status ChangedProgram::check_span() const {
  if (triangulation_->kernel_dimension() == setting_->dimension) return success();
  return error(Errc::usage, setting_->result + ": the points that would be left all lie " +
                                (setting_->dimension == 3 ? "in a plane" : "on a line") +
                                ", so they have no triangulation");
}

Result<std::unique_ptr<Finished>> ChangedProgram::finish() {
  TileEnd end{.begun = begun_, .awake = triangulation_ != nullptr};
  if (!triangulation_) {
    BOOST_OUTCOME_TRY(concerned, concerns());
    if (!concerned) return std::unique_ptr<Finished>(std::make_unique<Untouched>());
  }
  if (!start_) {
    BOOST_OUTCOME_TRYV(read(false));
  }
  end.lost = start_->lost;
  if (!triangulation_ && (start_->lost || reshaped_) && !start_->points.empty()) {
    start_->begins = false;
    BOOST_OUTCOME_TRYV(build());
    counts_ = {};
    end.awake = true;
  }
  if (triangulation_) {
    BOOST_OUTCOME_TRYV(check_span());
  }
  end.counts = counts_;
  end.changed = begun_ || start_->lost || reshaped_ || counts_.inserted > 0;
  end.removed_bounds = start_->removed_bounds;
  end.duplicates = std::move(start_->duplicates);
  std::unique_ptr<CollectedTile> cells;
  if (triangulation_ && end.changed) {
    for (const Point& p : start_->points) end.bounds.add(p);
    cells =
        std::make_unique<CollectedTile>(triangulation_->collect(std::move(start_->points), std::move(start_->ids), {}));
  }
  return std::unique_ptr<Finished>(
      std::make_unique<ChangedEnd>(*setting_->store, self_, std::move(end), std::move(cells)));
}

std::size_t ChangedProgram::memory() const {
  const std::size_t start = start_ ? start_->points.size() * (sizeof(Point) + sizeof(PointId)) : 0;
  return sizeof *this + heard_.memory() + (triangulation_ ? triangulation_->memory() : 0) + start;
}

}  // namespace tessera
