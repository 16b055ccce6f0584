// HDF5 identifiers that close themselves, and its errors as one sentence. HDF5 calls are serialised by the library's
// own lock, so bulk data never goes through them: see tile_file.cc.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/store/files.h"

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

inline Hdf5Handle space_of(const std::vector<hsize_t>& shape) {
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose};
}
inline Hdf5Handle property_list(hid_t kind) { return {H5Pcreate(kind), H5Pclose}; }

hid_t hdf5_type(AttributeType type);

// New file, group /VTKHDF with its two attributes; reproducible: no times, one version of the format.
struct VtkHdfFile {
  Hdf5Handle file, group, point_data, cell_data;
  bool ok() const { return file.ok() && group.ok() && point_data.ok() && cell_data.ok(); }
};
// `path` is created and stays empty: what HDF5 writes goes to `memory`. HDF5 1.10 leaves a file that it could not
// close, because the disk is full, in its tables, and crashes on it when the process ends.
VtkHdfFile create_vtkhdf(const std::string& path, const MemoryFile& memory);

// A small array written at once.
bool write_counts(hid_t group, const char* name, const std::vector<std::int64_t>& values);

// Properties of a dataset without modification times.
Hdf5Handle dataset_properties();

}  // namespace tessera::store
