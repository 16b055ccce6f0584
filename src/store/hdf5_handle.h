// HDF5 identifiers that close themselves, and its errors as one sentence.
#pragma once

#include <hdf5.h>

#include <string>
#include <utility>

#include "src/base/attribute.h"

namespace tessera::store {

// Negative: the call failed.
class Hdf5Handle {
 public:
  using Closer = herr_t (*)(hid_t);
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Closer closer) : id_(id), closer_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), closer_(other.closer_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(closer_, other.closer_);
    return *this;
  }
  ~Hdf5Handle() { close(); }
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }
  // True when the library flushed and closed without complaint.
  bool close() { return id_ < 0 || closer_(std::exchange(id_, -1)) >= 0; }

 private:
  hid_t id_ = -1;
  Closer closer_ = nullptr;
};

// Keeps HDF5 from printing its error stack in this thread (the setting is per thread in a thread-safe build).
struct QuietHdf5 {
  QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }
};

// The innermost reason of the last failed call in this thread: "write failed: No space left on device".
std::string hdf5_reason();

inline Hdf5Handle property_list(hid_t kind) { return {H5Pcreate(kind), H5Pclose}; }

// How files are opened: without HDF5's own locks, which fail on network file systems. A folder's lock is FolderLock.
Hdf5Handle file_access();

hid_t hdf5_type(AttributeType type);

}  // namespace tessera::store
