// Objects: what is read by a name such as https://host/block.copc.laz, and is no file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// Whether a name begins with a scheme ("https://"), so that it means an object and not a file.
bool names_object(std::string_view name);

// Takes the bytes of an object, in order. An error ends the transfer.
class ObjectTaker {
 public:
  virtual ~ObjectTaker() = default;
  virtual Status begin(std::uint64_t bytes) = 0;  // how many there are
  virtual Status take(std::span<const std::byte> bytes) = 0;
};

// An object to write.
struct NewObject {
  std::string name;
  std::uint64_t bytes = 0;
  // Fills `out` with the bytes from the offset on. Called by several threads at once.
  std::function<Status(std::uint64_t offset, std::span<std::byte> out)> read;
  bool only_new = false;  // error usage when there is an object of this name
};

// The one way to objects. Thread-safe.
class Objects {
 public:
  virtual ~Objects() = default;
  // Opens an object. The path() of the source is its name without secrets. `stop` ends its reads soon, with
  // Errc::interrupted. Errors: usage for a name that cannot be read or is not allowed; io when the server does not
  // answer or refuses; bad_input when its answers contradict each other.
  virtual Result<std::shared_ptr<const ByteSource>> open(const std::string& name, std::stop_token stop) = 0;
  // The names of the objects that a name stands for: those in a folder of a store (s3://bucket/folder/; with
  // `recursive` also below it), and otherwise the name itself. Errors: those of open(); io for a folder without point
  // files.
  virtual Result<std::vector<std::string>> names(const std::string& name, bool recursive, std::stop_token stop) = 0;
  // Passes on a whole object. Errors: those of open(), and those of the taker.
  virtual Status copy(const std::string& name, ObjectTaker& to, std::stop_token stop) = 0;
  // Whether there is an object of this name that may be read. Errors: those of open(), except for what is missing or
  // must not be read.
  virtual Result<bool> exists(const std::string& name, std::stop_token stop) = 0;
  // Writes objects, many at once. Each is there whole or not at all. `told` is called with the numbers of bytes that
  // have arrived, by several threads at once. Errors: usage for a store that cannot be written; those of
  // NewObject::read; io when the server does not answer or refuses; interrupted. What has begun is given up then.
  virtual Status put(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
                     std::stop_token stop) = 0;
  // Whether objects may be written beside an object of this name, which need not exist: begins to write it, and gives
  // up. Errors: those of put().
  virtual Status check_writable(const std::string& name, std::stop_token stop) = 0;
  // Removes an object. A missing object is no error.
  virtual Status remove(const std::string& name, std::stop_token stop) = 0;
};

// Says how this process opens objects. Until then, and for null, it opens none. One for all of a process: no list of
// inputs and no request can lead round what the process allows.
void set_objects(std::shared_ptr<Objects> objects);

// Whether this process opens objects.
bool reads_objects();
// From now on, requests without a stop token of their own end soon after this one is requested.
void stop_objects_by(std::stop_token stop);

// The functions of Objects of this thread, or else of this process. Error usage if it has none.
Result<std::shared_ptr<const ByteSource>> open_object(const std::string& name, std::stop_token stop);
Result<std::vector<std::string>> object_names(const std::string& name, bool recursive, std::stop_token stop);
Status copy_object(const std::string& name, ObjectTaker& to, std::stop_token stop);
Result<bool> object_exists(const std::string& name, std::stop_token stop);
Status put_objects(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
                   std::stop_token stop);
Status check_writable_object(const std::string& name, std::stop_token stop);
Status remove_object(const std::string& name, std::stop_token stop);

// Until destroyed, the thread that made it opens objects in this way, whatever the process does, and so do the threads
// of in_order() that it starts. For programs whose calls have different rights.
class UseObjects {
 public:
  explicit UseObjects(std::shared_ptr<Objects> objects);
  ~UseObjects();
  UseObjects(const UseObjects&) = delete;
  UseObjects& operator=(const UseObjects&) = delete;
  // Null when this thread has none.
  static std::shared_ptr<Objects> of_thread();

 private:
  std::shared_ptr<Objects> before_;
};

}  // namespace tessera
