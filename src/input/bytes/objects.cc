#include "src/input/bytes/objects.h"

#include <algorithm>
#include <cctype>
#include <mutex>
#include <utility>

namespace tessera {
namespace {

struct Way {
  std::mutex mutex;
  std::shared_ptr<Objects> objects;
  std::stop_token stop;
};

Way& way() {
  static Way all;
  return all;
}

thread_local std::shared_ptr<Objects> objects_of_thread;

Result<std::shared_ptr<Objects>> objects_for(const std::string& name) {
  if (objects_of_thread) return objects_of_thread;
  {
    const std::lock_guard lock(way().mutex);
    if (way().objects) return way().objects;
  }
  // A name may have a secret behind '?' or before '@'.
  const auto scheme = name.substr(0, name.find("://") + 3);
  return error(Errc::usage, "an input begins with " + scheme + ", but this process reads files only");
}

std::stop_token stop_of(std::stop_token given) {
  if (given.stop_possible()) return given;
  const std::lock_guard lock(way().mutex);
  return way().stop;
}

}  // namespace

bool names_object(std::string_view name) {
  const auto end = name.find("://");
  if (end == std::string_view::npos || end == 0 || std::isalpha(static_cast<unsigned char>(name[0])) == 0) return false;
  return std::all_of(name.begin(), name.begin() + static_cast<std::ptrdiff_t>(end),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '+' || c == '-' || c == '.'; });
}

void set_objects(std::shared_ptr<Objects> objects) {
  const std::lock_guard lock(way().mutex);
  way().objects = std::move(objects);
}

bool reads_objects() {
  const std::lock_guard lock(way().mutex);
  return way().objects != nullptr;
}

UseObjects::UseObjects(std::shared_ptr<Objects> objects)
    : before_(std::exchange(objects_of_thread, std::move(objects))) {}

UseObjects::~UseObjects() { objects_of_thread = std::move(before_); }

std::shared_ptr<Objects> UseObjects::of_thread() { return objects_of_thread; }

void stop_objects_by(std::stop_token stop) {
  const std::lock_guard lock(way().mutex);
  way().stop = std::move(stop);
}

Result<std::shared_ptr<const ByteSource>> open_object(const std::string& name, std::stop_token stop) {
  BOOST_OUTCOME_TRY(objects, objects_for(name));
  return objects->open(name, stop_of(std::move(stop)));
}

Result<std::vector<std::string>> object_names(const std::string& name, bool recursive, std::stop_token stop) {
  BOOST_OUTCOME_TRY(objects, objects_for(name));
  return objects->names(name, recursive, stop_of(std::move(stop)));
}

Status copy_object(const std::string& name, ObjectTaker& to, std::stop_token stop) {
  BOOST_OUTCOME_TRY(objects, objects_for(name));
  return objects->copy(name, to, stop_of(std::move(stop)));
}

Result<bool> object_exists(const std::string& name, std::stop_token stop) {
  BOOST_OUTCOME_TRY(objects, objects_for(name));
  return objects->exists(name, stop_of(std::move(stop)));
}

Status put_objects(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
                   std::stop_token stop) {
  if (objects.empty()) return success();
  BOOST_OUTCOME_TRY(store, objects_for(objects.front().name));
  return store->put(objects, told, stop_of(std::move(stop)));
}

Status check_writable_object(const std::string& name, std::stop_token stop) {
  BOOST_OUTCOME_TRY(objects, objects_for(name));
  return objects->check_writable(name, stop_of(std::move(stop)));
}

Status remove_object(const std::string& name, std::stop_token stop) {
  BOOST_OUTCOME_TRY(objects, objects_for(name));
  return objects->remove(name, stop_of(std::move(stop)));
}

}  // namespace tessera
