// Loads HDF5 when it is first needed, so that machines without it can do all else. Functions are looked up by name.
#pragma once

// Programs are compiled without the variables of the library: what the macros of its headers would name is looked up.
#include <hdf5.h>

#include <mutex>
#include <utility>

#include "src/base/attribute.h"
#include "src/base/result.h"

namespace tessera {

// clang-format off
#define TESSERA_HDF5_FUNCTIONS(F) \
  F(H5Aclose) F(H5Acreate2) F(H5Aexists) F(H5Aget_space) F(H5Aget_type) F(H5Aopen) F(H5Aread) F(H5Awrite) \
  F(H5Dclose) F(H5Dcreate2) F(H5Dget_create_plist) F(H5Dget_offset) F(H5Dget_space) F(H5Dget_type) F(H5Dopen2) \
  F(H5Dread) F(H5Eset_auto2) F(H5FDregister) F(H5Fclose) F(H5Fcreate) F(H5Fopen) F(H5Gclose) F(H5Gcreate2) F(H5Gget_info) \
  F(H5Gopen2) F(H5Lexists) F(H5Lget_info) F(H5Lget_name_by_idx) F(H5PLset_loading_state) F(H5Pclose) F(H5Pcreate) \
  F(H5Pget_chunk) F(H5Pget_driver_info) F(H5Pget_external_count) F(H5Pget_filter2) F(H5Pget_layout) \
  F(H5Pget_nfilters) F(H5Pset_alloc_time) F(H5Pset_chunk_cache) F(H5Pset_create_intermediate_group) F(H5Pset_driver) \
  F(H5Pset_fill_time) F(H5Pset_obj_track_times) F(H5Sclose) F(H5Screate) F(H5Screate_simple) \
  F(H5Sget_simple_extent_dims) F(H5Sget_simple_extent_ndims) F(H5Sselect_hyperslab) F(H5Tclose) F(H5Tcopy) \
  F(H5Tget_class) F(H5Tget_sign) F(H5Tget_size) F(H5Tset_cset) F(H5Tset_size) F(H5get_libversion) F(H5open)
#define TESSERA_HDF5_VARIABLES(V) \
  V(H5P_CLS_DATASET_ACCESS_ID_g) V(H5P_CLS_DATASET_CREATE_ID_g) V(H5P_CLS_FILE_ACCESS_ID_g) \
  V(H5P_CLS_LINK_CREATE_ID_g) V(H5T_NATIVE_UINT8_g) V(H5T_NATIVE_INT8_g) V(H5T_NATIVE_UINT16_g) \
  V(H5T_NATIVE_INT16_g) V(H5T_NATIVE_UINT32_g) V(H5T_NATIVE_INT32_g) V(H5T_NATIVE_UINT64_g) V(H5T_NATIVE_INT64_g) \
  V(H5T_NATIVE_FLOAT_g) V(H5T_NATIVE_DOUBLE_g) V(H5T_C_S1_g)
// clang-format on

struct Hdf5Library {
#define TESSERA_HDF5_MEMBER(name) decltype(&::name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  TESSERA_HDF5_FUNCTIONS(TESSERA_HDF5_MEMBER)
#undef TESSERA_HDF5_MEMBER
#define TESSERA_HDF5_VARIABLE(name) hid_t name = -1;
  TESSERA_HDF5_VARIABLES(TESSERA_HDF5_VARIABLE)
#undef TESSERA_HDF5_VARIABLE
};

// The library, loaded once. It prints nothing, and loads no filters. Error io when HDF5 is not installed, or is of a
// version whose drivers are others. Thread-safe.
Result<const Hdf5Library*> hdf5_library();

// Whoever calls the library holds this: not every build of HDF5 may be called by several threads.
std::mutex& hdf5_mutex();

// The type of numbers in memory.
hid_t hdf5_memory_type(const Hdf5Library& hdf5, AttributeType type);

// A handle of HDF5 that is closed at the end.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Handle(hid_t id, Close how) : id_(id), close_(how) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(Hdf5Handle&&) = delete;
  ~Hdf5Handle() { close(); }
  // Closes the handle now. Returns false when HDF5 cannot.
  bool close() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }
  hid_t get() const { return id_; }
  explicit operator bool() const { return id_ >= 0; }

 private:
  hid_t id_;
  Close close_;
};

}  // namespace tessera
