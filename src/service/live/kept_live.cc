#include "src/service/live/kept_live.h"

#include <algorithm>
#include <exception>
#include <new>
#include <set>
#include <utility>

namespace tessera::service {
namespace {

constexpr std::size_t batch_points_max = 1 << 17, batch_requests_max = 256;
constexpr std::size_t boxes_max = 1000;  // of an event
constexpr std::size_t numbers_kept = 16;

proto::Box box_of(const Bounds& bounds, int dimension) {
  proto::Box box;
  for (const Point& corner : {bounds.lo, bounds.hi})
    for (int axis = 0; axis < dimension; ++axis) box.add_bounds(corner[axis]);
  return box;
}

std::uint64_t distinct(const std::vector<PointId>& ids) { return std::set<PointId>(ids.begin(), ids.end()).size(); }

Error no_memory_for_points() { return error(Errc::memory, "no memory is left to change a result"); }

}  // namespace

struct KeptLive::Waiting {
  const ResultChange& change;
  EqualToNew equal;
  std::stop_token stop;
  std::optional<Result<proto::PointsChanged>> done = {};
  std::size_t points() const { return change.add.size() + change.remove.size(); }
};

KeptLive::KeptLive(std::filesystem::path folder, KeptLiveOptions options, std::unique_ptr<LiveResult> live)
    : folder_(std::move(folder)),
      options_(std::move(options)),
      manifest_(live->source().manifest()),
      events_(std::make_shared<VersionEvents>(live->current()->number())),
      current_(live->current()),
      live_(std::move(live)) {
  const LiveState now = live_->state();
  numbers_[now.stored_version] = now.stored;
}

Result<std::unique_ptr<KeptLive>> KeptLive::open(const std::filesystem::path& folder, KeptLiveOptions options) {
  BOOST_OUTCOME_TRY(live, LiveResult::open(folder, options.live));
  return std::unique_ptr<KeptLive>(new KeptLive(folder, std::move(options), std::move(live)));
}

// The first caller who finds nobody at work applies the changes of all who wait, its own or those before it.
Result<proto::PointsChanged> KeptLive::change(const ResultChange& change, EqualToNew equal,
                                              const std::stop_token& stop) {
  Waiting mine{change, equal, stop};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&mine);
  while (!mine.done) {
    if (busy_) {
      changed_.wait(lock);
      continue;
    }
    busy_ = true;
    const auto batch = take();
    lock.unlock();
    run(batch);
    lock.lock();
    busy_ = false;
    changed_.notify_all();
  }
  lock.unlock();
  if (should_store() && options_.grown) options_.grown();
  return *std::move(mine.done);
}

// A point that two callers remove is there for the first of them alone, so the second one's change waits. New points
// that replace others also replace those of the changes before, so their change is a batch of its own. REQUIRES:
// `mutex_` is held.
std::vector<KeptLive::Waiting*> KeptLive::take() {
  std::vector<Waiting*> batch;
  std::set<PointId> removed;
  std::size_t points = 0;
  while (!waiting_.empty() && batch.size() < batch_requests_max) {
    Waiting* next = waiting_.front();
    const auto& remove = next->change.remove;
    const bool alone = next->equal == EqualToNew::go;
    if (!batch.empty() && (alone || points + next->points() > batch_points_max ||
                           std::any_of(remove.begin(), remove.end(), [&](PointId id) { return removed.contains(id); })))
      break;
    points += next->points();
    removed.insert(remove.begin(), remove.end());
    batch.push_back(next);
    waiting_.pop_front();
    if (alone) break;
  }
  return batch;
}

void KeptLive::run(const std::vector<Waiting*>& batch) {
  try {
    std::vector<Waiting*> still;
    for (Waiting* one : batch) {
      if (one->stop.stop_requested())
        one->done = error(Errc::interrupted, "the caller has gone before the points were changed");
      else
        still.push_back(one);
    }
    if (still.size() > 1 && try_together(still)) return;
    for (Waiting* one : still) {
      const auto applied = apply(one->change, one->equal);
      if (!applied) {
        one->done = applied.error();
        continue;
      }
      proto::PointsChanged told;
      told.set_version(applied.value().version);
      told.set_first_id(applied.value().first_new);
      told.set_added(one->change.add.size());
      told.set_equal(applied.value().equal.size());
      told.set_removed(applied.value().removed);
      one->done = std::move(told);
    }
  } catch (const std::bad_alloc&) {
    for (Waiting* one : batch)
      if (!one->done) one->done = no_memory_for_points();
  } catch (const std::exception& thrown) {
    for (Waiting* one : batch)
      if (!one->done) one->done = error(Errc::internal, thrown.what());
  }
}

// Returns false when nothing has changed, so that the changes can be applied one by one. When it is not known whether
// the log has the batch, they must not be: they would happen twice.
bool KeptLive::try_together(const std::vector<Waiting*>& batch) {
  ResultChange all;
  for (const Waiting* one : batch) {
    all.add.insert(all.add.end(), one->change.add.begin(), one->change.add.end());
    all.rows.insert(all.rows.end(), one->change.rows.begin(), one->change.rows.end());
    all.remove.insert(all.remove.end(), one->change.remove.begin(), one->change.remove.end());
  }
  const auto applied = apply(all, EqualToNew::stay);
  if (!applied) {
    if (!state().broken) return false;
    for (Waiting* one : batch) one->done = applied.error();
    return true;
  }
  std::uint64_t first = applied.value().first_new;
  for (Waiting* one : batch) {
    const std::uint64_t end = first + one->change.add.size();
    const auto& ids = applied.value().equal;
    const auto equal = std::lower_bound(ids.begin(), ids.end(), PointId{end}) -
                       std::lower_bound(ids.begin(), ids.end(), PointId{first});
    proto::PointsChanged told;
    told.set_version(applied.value().version);
    told.set_first_id(first);
    told.set_added(one->change.add.size());
    told.set_equal(static_cast<std::uint64_t>(equal));
    told.set_removed(distinct(one->change.remove));
    one->done = std::move(told);
    first = end;
  }
  return true;
}

Result<LiveApplied> KeptLive::apply(const ResultChange& change, EqualToNew equal) {
  BOOST_OUTCOME_TRYV(mend());
  const std::shared_lock lock(live_mutex_);
  BOOST_OUTCOME_TRY(applied, live_->apply(change, equal));
  publish();
  tell(applied, change.add.size());
  return applied;
}

// A batch and a store may end at once. The later one to come here publishes what is newest then.
void KeptLive::publish() {
  const std::lock_guard lock(publishing_);
  current_ = live_->current();
}

void KeptLive::tell(const LiveApplied& applied, std::uint64_t added) {
  proto::VersionMade made;
  made.set_version(applied.version);
  made.set_added(added);
  made.set_removed(applied.removed);
  std::vector<Bounds> boxes = applied.changed;
  if (boxes.size() > boxes_max) {  // one box instead
    for (const Bounds& box : applied.changed) boxes.front().add(box);
    boxes.resize(1);
  }
  for (const Bounds& box : boxes) *made.add_changed() = box_of(box, manifest_.dimension);
  events_->tell(std::move(made));
}

// After an error of the disk nobody knows what the log has, so the result is opened again.
Status KeptLive::mend() {
  {
    const std::shared_lock lock(live_mutex_);
    if (live_ && !live_->state().broken) return success();
  }
  const std::unique_lock lock(live_mutex_);
  live_.reset();
  auto opened = LiveResult::open(folder_, options_.live);
  if (!opened) {
    why_not_ = opened.error();
    return why_not_;
  }
  live_ = std::move(opened).value();
  const auto now = live_->current();
  const std::uint64_t before = current_.load()->number();
  current_ = now;
  if (now->number() == before) return success();
  proto::VersionMade made;
  made.set_version(now->number());
  made.set_everything(true);
  events_->tell(std::move(made));
  return success();
}

LiveState KeptLive::state() const {
  const std::shared_lock lock(live_mutex_);
  if (live_) return live_->state();
  LiveState none;
  none.version = current_.load()->number();
  none.broken = why_not_;
  return none;
}

// A version that is newer than the stored one is just being stored. Batches wait meanwhile, so it is the newest
// version.
std::optional<std::uint64_t> KeptLive::number_of(std::uint32_t stored_version) const {
  const LiveState now = state();
  const std::lock_guard lock(mutex_);
  if (stored_version == now.stored_version) return now.stored;
  if (stored_version == now.stored_version + 1) return now.version;
  const auto found = numbers_.find(stored_version);
  return found == numbers_.end() ? std::nullopt : std::optional(found->second);
}

bool KeptLive::should_store() const {
  const std::uint64_t bytes = state().log_bytes;
  const std::lock_guard lock(mutex_);
  return bytes > options_.log_bytes_max && bytes >= not_before_bytes_;
}

Status KeptLive::store() {
  const std::shared_lock lock(live_mutex_);
  if (!live_) return why_not_;
  const std::uint64_t before = live_->state().stored;
  const Status stored = live_->checkpoint();
  publish();
  const LiveState now = live_->state();
  if (now.stored != before) events_->tell_stored(now.stored);
  const std::lock_guard bookkeeping(mutex_);
  not_before_bytes_ = stored ? 0 : now.log_bytes + options_.log_bytes_max;
  numbers_[now.stored_version] = now.stored;
  if (numbers_.size() > numbers_kept) numbers_.erase(numbers_.begin());
  return stored;
}

}  // namespace tessera::service
