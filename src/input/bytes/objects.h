// Objects: what is read by a name such as https://host/block.copc.laz, and is no file.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// Whether a name begins with a scheme ("https://"), so that it means an object and not a file.
bool names_object(std::string_view name);

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
};

// Says how this process opens objects. Until then, and for null, it opens none. One for all of a process: no list of
// inputs and no request can lead round what the process allows.
void set_objects(std::shared_ptr<Objects> objects);

// Whether this process opens objects.
bool reads_objects();
// Objects::open() and names() of this thread, or else of this process. Error usage if it opens none.
Result<std::shared_ptr<const ByteSource>> open_object(const std::string& name, std::stop_token stop);
Result<std::vector<std::string>> object_names(const std::string& name, bool recursive, std::stop_token stop);

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
