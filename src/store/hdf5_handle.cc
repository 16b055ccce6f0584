#include "src/store/hdf5_handle.h"

namespace tessera::store {

std::string hdf5_reason() {
  std::string reason = "HDF5 failed";
  const auto take = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    if (entry->desc != nullptr) *static_cast<std::string*>(data) = std::string("HDF5: ") + entry->desc;
    return 1;  // walking upward, the first entry is the innermost: stop
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &reason);
  return reason;
}

hid_t hdf5_type(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
      return H5T_STD_U8LE;
    case AttributeType::i8:
      return H5T_STD_I8LE;
    case AttributeType::u16:
      return H5T_STD_U16LE;
    case AttributeType::i16:
      return H5T_STD_I16LE;
    case AttributeType::u32:
      return H5T_STD_U32LE;
    case AttributeType::i32:
      return H5T_STD_I32LE;
    case AttributeType::u64:
      return H5T_STD_U64LE;
    case AttributeType::i64:
      return H5T_STD_I64LE;
    case AttributeType::f32:
      return H5T_IEEE_F32LE;
    case AttributeType::f64:
      return H5T_IEEE_F64LE;
  }
  return -1;
}

Hdf5Handle file_access() {
  Hdf5Handle access = property_list(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 10, 7)
  H5Pset_file_locking(access, false, true);
#endif
  return access;
}

}  // namespace tessera::store
