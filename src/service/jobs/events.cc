#include "src/service/jobs/events.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <system_error>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/thread_name.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t reserved_at_once = 1'000'000;
constexpr std::uint64_t number_max = std::uint64_t{1} << 53;  // largest number that JSON readers keep exactly

// Greater than all numbers that any daemon has given, unless it gave a million a second.
std::uint64_t microseconds_since_1970() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace

// The delivering thread owns `next` and `before`. `mutex` guards `alive`, and is held while on_event runs; it is
// recursive because a listener may leave inside on_event.
class Events::Listener {
 public:
  Listener(std::string job, std::uint64_t next, OnEvent on_event)
      : job(std::move(job)), next(next), on_event(std::move(on_event)) {}

  void tell(const Shared& event) {
    if (!job.empty() && event->job_id() != job) return;
    const std::lock_guard lock(mutex);
    if (alive) on_event(event);
  }

  const std::string job;
  std::uint64_t next;
  std::vector<Shared> before;
  std::recursive_mutex mutex;
  bool alive = true;
  const OnEvent on_event;
};

Result<std::unique_ptr<Events>> Events::open(fs::path numbers, StagingFolder& desk,
                                             const std::function<void(const std::string&)>& log) {
  std::unique_ptr<Events> events(new Events(std::move(numbers), desk));
  const auto tell = [&](const std::string& line) {
    if (log) log(line);
  };
  std::uint64_t from = 1;
  BOOST_OUTCOME_TRY(there, is_there(events->numbers_));
  if (there) {
    BOOST_OUTCOME_TRY(bytes, read_whole(events->numbers_));
    const auto text = as_text(bytes);
    const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), from);
    if (ec != std::errc{} || end == text.data() || from > number_max) {
      from = microseconds_since_1970();
      tell(events->numbers_.string() + ": does not hold the number of the next event; events are numbered from " +
           std::to_string(from));
    }
  }
  // On a full disk numbers go on unreserved, as in tell().
  if (const Status reserved = events->reserve(from); !reserved) {
    tell(reserved.error().where +
         "; events are numbered without this file, and after a crash some numbers may occur twice");
    events->reserved_ = from + 1;
  }
  events->next_ = from;
  events->thread_ = std::thread([self = events.get()] { self->deliver(); });
  return events;
}

Events::~Events() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Status Events::reserve(std::uint64_t from) {
  BOOST_OUTCOME_TRYV(desk_.write(numbers_, std::to_string(from + reserved_at_once) + "\n"));
  reserved_ = from + reserved_at_once;
  return success();
}

void Events::tell(proto::Event event) {
  {
    const std::lock_guard lock(mutex_);
    // Numbers for ten million jobs are reserved at a time. On a full disk numbers go on unreserved: only a crash before
    // the next attempt could give numbers twice.
    if (next_ >= reserved_ && !reserve(next_)) reserved_ = next_ + 1;
    event.set_id(next_++);
    kept_.push_back(std::make_shared<const proto::Event>(std::move(event)));
    if (kept_.size() > kept_max) kept_.pop_front();
  }
  changed_.notify_all();
}

std::shared_ptr<Events::Listener> Events::listen(std::string job, std::uint64_t last, OnEvent on_event,
                                                 const std::function<std::vector<proto::Event>()>& instead) {
  const auto listener = std::make_shared<Listener>(std::move(job), 0, std::move(on_event));
  std::unique_lock lock(mutex_);
  const std::uint64_t first = kept_.empty() ? next_ : kept_.front()->id();
  if (last == 0) {
    listener->next = next_;
  } else if (last + 1 >= first && last < next_) {
    listener->next = last + 1;
  } else {
    lock.unlock();  // the code that makes them may call tell()
    for (auto& event : instead()) {
      event.set_id(first - 1);
      listener->before.push_back(std::make_shared<const proto::Event>(std::move(event)));
    }
    listener->next = first;
    lock.lock();
  }
  listeners_.push_back(listener);
  new_listener_ = true;
  changed_.notify_all();
  return listener;
}

void Events::leave(const std::shared_ptr<Listener>& listener) {
  {
    const std::lock_guard lock(mutex_);
    std::erase(listeners_, listener);
  }
  const std::lock_guard lock(listener->mutex);  // until on_event has returned
  listener->alive = false;
}

std::size_t Events::listeners() const {
  const std::lock_guard lock(mutex_);
  return listeners_.size();
}

void Events::deliver() {
  name_thread("events");
  std::uint64_t told = 0;  // everything before it was delivered to those who were there
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return ending_ || new_listener_ || told < next_; });
    if (ending_) return;
    new_listener_ = false;
    told = next_;
    const auto listeners = listeners_;
    // The first event that a listener still needs.
    std::uint64_t least = next_;
    for (const auto& listener : listeners) least = std::min(least, listener->next);
    const auto begin = std::lower_bound(kept_.begin(), kept_.end(), least,
                                        [](const Shared& event, std::uint64_t id) { return event->id() < id; });
    const std::vector<Shared> events(begin, kept_.end());
    lock.unlock();
    for (const auto& listener : listeners) {
      for (const auto& event : std::exchange(listener->before, {})) listener->tell(event);
      const auto from = std::lower_bound(events.begin(), events.end(), listener->next,
                                         [](const Shared& event, std::uint64_t id) { return event->id() < id; });
      for (auto event = from; event != events.end(); ++event) listener->tell(*event);
      listener->next = std::max(listener->next, told);
    }
    lock.lock();
  }
}

}  // namespace tessera::service
